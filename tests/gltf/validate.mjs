// node validate.mjs [--quiet] FILE_OR_FOLDER...
//
// Runs the Khronos glTF validator on .glb and .gltf files, or on all files of a folder. Prints one line per file, then its
// messages, for example:
//
//     out.glb: 0 errors, 0 warnings, 0 infos, 0 hints
// Ends with 1 if any file has an error or a warning, with 2 if nothing could be checked. --quiet leaves out files
// without any message. Needs: npm ci --prefix tests/gltf

import { readFileSync, readdirSync, statSync } from 'node:fs';
import { dirname, join } from 'node:path';

let validator;
try {
  validator = (await import('gltf-validator')).default;
} catch {
  console.error('gltf-validator is not installed: run npm ci --prefix tests/gltf');
  process.exit(2);
}

const SEVERITIES = ['errors', 'warnings', 'infos', 'hints'];  // in the order of the validator's numbers

function isModel(name) {
  return name.endsWith('.glb') || name.endsWith('.gltf');
}

function modelsOf(path) {
  if (!statSync(path).isDirectory()) return [path];
  return readdirSync(path).filter(isModel).sort().map((name) => join(path, name));
}

async function validate(path) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), {
    uri: path,
    maxIssues: 20,
    writeTimestamp: false,
    externalResourceFunction: async (uri) =>
      new Uint8Array(readFileSync(join(dirname(path), decodeURIComponent(uri)))),
  });
  return report.issues;
}

const names = process.argv.slice(2).filter((argument) => argument !== '--quiet');
const quiet = process.argv.includes('--quiet');
const files = names.flatMap(modelsOf);
if (files.length === 0) {
  console.error('no .glb or .gltf file to check');
  process.exit(2);
}

let bad = 0;
for (const file of files) {
  const issues = await validate(file);
  const counts = [issues.numErrors, issues.numWarnings, issues.numInfos, issues.numHints];
  if (counts[0] + counts[1] > 0) bad += 1;
  if (quiet && issues.messages.length === 0) continue;
  console.log(`${file}: ${SEVERITIES.map((name, i) => `${counts[i]} ${name}`).join(', ')}`);
  for (const message of issues.messages) {
    console.log(`  ${SEVERITIES[message.severity].slice(0, -1)} ${message.code} ${message.pointer ?? ''}: ${message.message}`);
  }
}
console.log(`${files.length} files, ${bad} with errors or warnings`);
process.exit(bad === 0 ? 0 : 1);
