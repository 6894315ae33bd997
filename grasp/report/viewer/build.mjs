// Makes the page without its data: template, style and script with three.js in one file.
//
//   node build.mjs OUTPUT
//
// Runs in a folder that holds these sources and node_modules.
import { build } from 'esbuild';
import { readFileSync, writeFileSync } from 'node:fs';

const bundle = async (entry) => {
  const result = await build({
    entryPoints: [entry], bundle: true, minify: true, write: false, charset: 'utf8',
    target: 'es2020', format: 'iife', legalComments: 'inline',
  });
  return result.outputFiles[0].text.trim();
};

// Replacements by functions: "$" means nothing special in them.
const [script, style] = await Promise.all([bundle('viewer.js'), bundle('style.css')]);
const page = readFileSync('page.html', 'utf8')
  .replace('/*STYLE*/', () => style)
  .replace('/*SCRIPT*/', () => script);
writeFileSync(process.argv[2], page);
