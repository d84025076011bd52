// Runs the Khronos glTF validator over every GLB below the given folders; fails on any error or
// warning. Needs node and `npm install gltf-validator` in this folder or above (NODE_PATH works).
//   node validate.mjs FOLDER…
import { createRequire } from "node:module";
import { readdirSync, readFileSync, statSync } from "node:fs";
import { join } from "node:path";

const require = createRequire(process.env.NODE_PATH ? join(process.env.NODE_PATH, "x.js") : import.meta.url);
const validator = require("gltf-validator");

const files = folder => readdirSync(folder).flatMap(name => {
  const path = join(folder, name);
  if (statSync(path).isDirectory()) return files(path);
  return path.endsWith(".glb") ? [path] : [];
});

let bad = 0;
for (const path of process.argv.slice(2).flatMap(files)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 0 });
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  console.log(`${path}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} infos`);
  if (numErrors + numWarnings > 0) {
    bad++;
    for (const { code, message, pointer, severity } of messages) if (severity < 2) console.log(`  ${code} ${pointer}: ${message}`);
  } else if (process.env.INFOS) {
    for (const { code, message, pointer } of messages) console.log(`  ${code} ${pointer}: ${message}`);
  }
}
process.exit(bad ? 1 : 0);
