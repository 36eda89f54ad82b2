// node bundle.mjs MODULES OUT NOTICES: the page's script and all it needs as one minified file, and the
// licences and notices of the packages that are really in it.
import { existsSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
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
  legalComments: 'external',  // beside it, in OUT.LEGAL.txt
  metafile: true,
  nodePaths: [modules],
  plugins: [withSuffix, withoutEval],
  logLevel: 'warning',
});

// ---- notices --------------------------------------------------------------------------------

// The texts that a package carries: at its top, and in licenses/ those of what it took from others.
function textsOf(folder) {
  const named = /^(licen[cs]e|notice|copying|copyright)/i;
  const files = readdirSync(folder, { withFileTypes: true })
    .filter((f) => f.isFile() && named.test(f.name)).map((f) => join(folder, f.name));
  const others = join(folder, 'licenses');
  if (existsSync(others)) files.push(...readdirSync(others).map((name) => join(others, name)));
  return files.map((file) => readFileSync(file, 'utf8').trim());
}

const bundled = [...new Set(Object.keys(metafile.inputs).map((path) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(path)?.[1])
  .filter((name) => name !== undefined))].sort();
const parts = bundled.map((name) => {
  const { version, license } = JSON.parse(readFileSync(join(modules, name, 'package.json'), 'utf8'));
  const texts = textsOf(join(modules, name));
  if (texts.length === 0) throw new Error(`${name} ${version} (${license}) carries no licence text`);
  return [`${name} ${version}${license ? ` (${license})` : ''}`, ...texts].join('\n\n');
});
const comments = existsSync(`${out}.LEGAL.txt`) ? readFileSync(`${out}.LEGAL.txt`, 'utf8').trim() : '';
if (comments) parts.push(`Comments in their sources\n\n${comments}`);
writeFileSync(notices, `${parts.join(`\n\n${'-'.repeat(80)}\n\n`)}\n`);
