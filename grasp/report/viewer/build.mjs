// Makes the pages without their data: template, style and script with three.js in one file each.
//
//   node build.mjs VIEWER TASK_VIEWER      grasps; tasks
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

const style = await bundle('style.css');
for (const [name, output] of [['viewer', process.argv[2]], ['task', process.argv[3]]]) {
  const script = await bundle(`${name}.js`);
  // Replacements by functions: "$" means nothing special in them.
  const page = readFileSync(name === 'viewer' ? 'page.html' : `${name}.html`, 'utf8')
    .replace('/*STYLE*/', () => style)
    .replace('/*SCRIPT*/', () => script);
  writeFileSync(output, page);
}
