// Loads every GLB of an exported folder with three.js in headless Chromium and looks at it.
//   node three.mjs FOLDER OUT [NAME…]
// Needs chromium (or CHROMIUM=its path) and `npm install three` in this folder, above, or in the
// folder of node_modules that NODE_PATH names. Fails when a tree does not stand on the ground, has
// another height than library.json says, shows another silhouette than its picture (upside down,
// mirrored, cut off) from the front or the back, or loses leaves at a distance, or when a KTX2 file
// (BC7 or UASTC) lacks levels or differs from its PNG. Of a crown it loads
// the leaf model, the surface and the impostors with their sample shader, and fails when these have
// not the size and the outline of the leaf model. Writes OUT/NAME.png (front, two sides, back, from
// above, far away; of a crown one row a form) and OUT/scatter.png, to be looked at.
import { spawn } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [folder, out, ...names] = process.argv.slice(2);
const above = path => (path === dirname(path) ? [path] : [path, ...above(dirname(path))]);
const modules = [process.env.NODE_PATH, ...above(here).map(path => join(path, "node_modules"))];
const three = modules.filter(Boolean).map(path => join(path, "three")).find(existsSync);
if (!three) throw new Error("three is not installed");
mkdirSync(out, { recursive: true });
const library = JSON.parse(readFileSync(join(folder, "library.json")));
const wanted = list => (list ?? []).filter(tree => !names.length || names.includes(tree.name));
const [trees, crowns] = [wanted(library.trees), wanted(library.crowns)];
const types = { ".js": "text/javascript", ".html": "text/html", ".png": "image/png", ".json": "application/json", ".wasm": "application/wasm" };

function answered(path) {
  if (path === "/") return [readFileSync(join(here, "three.html")), ".html"];
  if (path === "/trees") return [JSON.stringify({ trees, crowns }), ".json"];
  const [root, rest] = path.startsWith("/three/") ? [three, path.slice(7)] : [folder, path.slice(8)];
  return [readFileSync(join(root, normalize(`/${rest}`))), extname(rest)];
}

async function body(request) {
  const parts = [];
  for await (const part of request) parts.push(part);
  return Buffer.concat(parts).toString();
}

const server = createServer(async (request, response) => {
  const path = decodeURIComponent(new URL(request.url, "http://local").pathname);
  try {
    if (request.method === "POST") {
      const text = await body(request);
      if (path === "/report") finished(JSON.parse(text));
      else writeFileSync(join(out, `${path.split("/").pop()}.png`), Buffer.from(text.split(",")[1], "base64"));
      return response.end();
    }
    const [content, ending] = answered(path);
    response.setHeader("content-type", types[ending] ?? "application/octet-stream");
    response.end(content);
  } catch {
    response.statusCode = 404;
    response.end();
  }
});

let browser;
const profile = mkdtempSync(join(tmpdir(), "three-"));
function finished(report) {
  let bad = 0;
  for (const { name, height, kept, complaints, offs = [] } of report) {
    bad += complaints.length;
    const told = complaints.length ? complaints.join("; ") : `${height.toFixed(2)} m, ${kept.toFixed(2)} of the leaves far away`;
    const read = offs.length ? `; ${offs.length} KTX2 files within ${Math.max(...offs).toFixed(1)} of 255` : "";
    console.log(`${name}: ${told}${read}`);
  }
  process.exitCode = bad || !report.length ? 1 : 0;
  browser.kill();
  server.close();
  server.closeAllConnections();
}

server.listen(0, "127.0.0.1", () => {
  const flags = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
  const page = `http://127.0.0.1:${server.address().port}/`;
  browser = spawn(process.env.CHROMIUM ?? "chromium", [...flags, `--user-data-dir=${profile}`, page], { stdio: "ignore" });
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
