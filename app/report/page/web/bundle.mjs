// node bundle.mjs MODULES OUT: the page's script and all it needs as one minified file.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const [modules, out] = process.argv.slice(2);
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

await build({
  entryPoints: [join(here, 'main.js')],
  outfile: out,
  bundle: true,
  minify: true,
  format: 'iife',
  target: 'es2020',
  legalComments: 'none',
  nodePaths: [modules],
  plugins: [withSuffix, withoutEval],
  logLevel: 'warning',
});
