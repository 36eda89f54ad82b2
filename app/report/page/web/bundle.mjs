// node bundle.mjs MODULES OUT NOTICES: the page's script and all it needs as one minified file, and the
// terms of every package that a byte of it comes from.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const [modules, out, notices] = process.argv.slice(2);
const here = dirname(fileURLToPath(import.meta.url));
const { build } = createRequire(join(modules, 'x.js'))('esbuild');

// echarts-gl imports "echarts/lib/util/layout"; echarts 6 and zrender 6 export only names with .js.
const withSuffix = {
  name: 'with-suffix',
  setup({ onResolve, resolve }) {
    onResolve({ filter: /^(echarts|zrender)\/lib\// }, ({ path, kind, importer }) => (path.endsWith('.js')
      ? undefined : resolve(`${path}.js`, { kind, importer, resolveDir: dirname(importer) })));
  },
};

// One place of the 3-D library makes functions of text, which the page's policy forbids: products.js.
const withoutEval = {
  name: 'without-eval',
  setup({ onLoad }) {
    onLoad({ filter: /claygl.src.createCompositor\.js$/ }, ({ path }) => {
      const before = "new Function('width', 'height', 'dpr', 'return ' + exprRes[1])";
      const text = readFileSync(path, 'utf8');
      if (!text.includes(before)) throw new Error(`${path} has changed: look for its eval`);
      return {
        contents: `import { products } from ${JSON.stringify(join(here, 'products.js'))};\n${text.replace(before, 'products(exprRes[1])')}`,
      };
    });
  },
};

const { metafile } = await build({
  entryPoints: [join(here, 'main.js')],
  outfile: out,
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'none',  // the page ends with the whole terms
  nodePaths: [modules],
  plugins: [withSuffix, withoutEval],
  logLevel: 'warning',
  metafile: true,
});

const packages = new Set();
for (const { inputs } of Object.values(metafile.outputs)) {
  for (const [path, { bytesInOutput }] of Object.entries(inputs)) {
    const name = path.match(/.*node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1];
    if (name && bytesInOutput > 0) packages.add(name);
  }
}
const terms = [...packages].sort().map((name) => {
  const folder = join(modules, name);
  const { version } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  const texts = ['NOTICE', 'LICENSE', 'LICENSE.txt', 'LICENSE.md', 'licenses/LICENSE-d3']
    .map((file) => join(folder, file)).filter(existsSync).map((file) => readFileSync(file, 'utf8').trim());
  if (texts.length === 0) throw new Error(`${name} has no licence text: what are its terms?`);
  return `@ ${name} ${version}\n\n${texts.join('\n\n')}\n`;
});
writeFileSync(notices, terms.join('\n'));
