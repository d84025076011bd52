"use strict";
// Shows one tree at a time. A tree comes as gallery.tree({...}) from its own script; the list of all
// as gallery.trees([...]). World: +Y up, metres, foot at the origin, the picture faces +Z.
const gallery = (() => {
  const canvas = document.getElementById("view");
  const gl = canvas.getContext("webgl", { antialias: true, alpha: false });
  const complain = text => {
    const box = document.getElementById("error");
    box.style.display = "grid";
    box.textContent = text;
  };
  if (!gl) {
    complain("This browser does not offer WebGL; the pictures in textures/ can be looked at.");
    return { trees() {}, tree() {} };
  }

  const program = (vertex, fragment) => {
    const made = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.bindAttribLocation(made, 0, "position");
    gl.bindAttribLocation(made, 1, "uv");
    gl.bindAttribLocation(made, 2, "frame");
    gl.bindAttribLocation(made, 3, "normal");
    gl.linkProgram(made);
    return made;
  };

  // frame: x is the turn of the card about +Y in radians, y is 1 for the front and -1 for the back.
  const treeProgram = program(`
    attribute vec3 position; attribute vec2 uv; attribute vec2 frame;
    uniform mat4 clip; varying vec2 at; varying vec2 side; varying vec3 world;
    void main() { at = uv; side = frame; world = position; gl_Position = clip * vec4(position, 1.0); }`, `
    precision highp float;
    varying vec2 at; varying vec2 side; varying vec3 world;
    uniform sampler2D albedo, normals; uniform vec3 sun; uniform float round;
    void main() {
      vec4 leaf = texture2D(albedo, at);
      if (leaf.a < 0.5) discard;
      vec3 n = mix(vec3(0.0, 0.0, 1.0), texture2D(normals, at).xyz * 2.0 - 1.0, round);
      n.z *= side.y;
      float c = cos(side.x), s = sin(side.x);
      n = normalize(vec3(c * n.x + s * n.z, n.y, -s * n.x + c * n.z));
      float direct = max(dot(n, sun), 0.0);
      float through = 0.25 * max(-dot(n, sun), 0.0);
      float sky = 0.5 + 0.25 * n.y;
      vec3 light = vec3(1.0, 0.95, 0.85) * (direct + through) * 1.1 + vec3(0.75, 0.85, 1.0) * sky;
      gl_FragColor = vec4(pow(pow(leaf.rgb, vec3(2.2)) * light, vec3(1.0 / 2.2)), 1.0);
    }`);
  const modelProgram = program(`
    attribute vec3 position; attribute vec2 uv; attribute vec3 normal;
    uniform mat4 clip; varying vec2 at; varying vec3 n;
    void main() { at = uv; n = normal; gl_Position = clip * vec4(position, 1.0); }`, `
    precision highp float;
    varying vec2 at; varying vec3 n;
    uniform sampler2D albedo; uniform vec3 sun; uniform float solid;
    void main() {
      vec4 leaf = texture2D(albedo, at);
      if (solid < 0.5 && leaf.a < 0.5) discard;
      vec3 m = normalize(n);
      float direct = max(dot(m, sun), 0.0);
      float through = 0.25 * max(-dot(m, sun), 0.0);
      vec3 light = vec3(1.0, 0.95, 0.85) * (direct + through) * 1.1 + vec3(0.75, 0.85, 1.0) * (0.5 + 0.25 * m.y);
      gl_FragColor = vec4(pow(pow(leaf.rgb, vec3(2.2)) * light, vec3(1.0 / 2.2)), 1.0);
    }`);
  const groundProgram = program(`
    attribute vec3 position; uniform mat4 clip; varying vec3 world;
    void main() { world = position; gl_Position = clip * vec4(position, 1.0); }`, `
    precision highp float;
    varying vec3 world; uniform vec3 color; uniform vec3 sun; uniform vec2 size;
    void main() {
      vec2 shade = (world.xz + sun.xz * size.y * 0.25) / (size.x * 0.6);
      float dark = 0.35 * exp(-2.0 * dot(shade, shade));
      float fade = smoothstep(4.0, 1.5, length(world.xz) / size.y);
      gl_FragColor = vec4(mix(color, mix(color, vec3(0.45, 0.5, 0.36), 0.5) * (1.0 - dark), fade), 1.0);
    }`);

  const loaded = new Map(), waiting = new Map();
  let shown = null, yaw = 0.6, pitch = 0.12, distance = 2.3, sunYaw = 0.9, sunPitch = 0.7, drawn = 0;

  const picture = source => new Promise((resolve, reject) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => reject(new Error("a picture cannot be read"));
    image.src = source;
  });

  const texture = image => {
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    if (image) gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    else gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 1, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array([128, 128, 255, 255]));
    const power = n => (n & (n - 1)) === 0;
    const mips = image && power(image.width) && power(image.height);
    if (mips) gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, mips ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return made;
  };

  const pixels = (image, width, height) => {
    const flat = document.createElement("canvas");
    flat.width = width; flat.height = height;
    const context = flat.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0, width, height);
    return context.getImageData(0, 0, width, height).data;
  };

  // The picture raised by its depth, front and back; cells in which nothing shows are left out. A
  // second copy across the first gives the tree an outline of leaves from the side, too.
  const raised = (tree, albedo, depth) => {
    const [w, h] = tree.size_px, scale = Math.min(1, 192 / Math.max(w, h));
    const columns = Math.max(2, Math.round(w * scale)), rows = Math.max(2, Math.round(h * scale));
    const seen = pixels(albedo, columns, rows), heights = pixels(depth, columns, rows);
    const visible = (x, y) => x >= 0 && y >= 0 && x < columns && y < rows && seen[4 * (y * columns + x) + 3] > 8;
    const vertices = [], indices = [], place = new Map();
    // Mean height of the texels around a corner that show.
    const height = (x, y) => {
      let sum = 0, count = 0;
      for (const [dx, dy] of [[-1, -1], [0, -1], [-1, 0], [0, 0]])
        if (visible(x + dx, y + dy)) { sum += heights[4 * ((y + dy) * columns + x + dx)]; count++; }
      return count ? sum / count / 255 * tree.depth_m : 0;
    };
    const corner = (x, y, front, turned) => {
      const key = (y * (columns + 1) + x) * 4 + (front > 0 ? 1 : 0) + (turned ? 2 : 0);
      if (!place.has(key)) {
        const u = x / columns, v = y / rows;
        const px = (u * w - tree.pivot_px[0]) * tree.metres_per_pixel, py = (tree.pivot_px[1] - v * h) * tree.metres_per_pixel;
        place.set(key, vertices.length / 7);
        const out = front * height(x, y);
        vertices.push(turned ? out : px, py, turned ? -px : out, u, v, turned ? Math.PI / 2 : 0, front);
      }
      return place.get(key);
    };
    for (let y = 0; y < rows; y++) for (let x = 0; x < columns; x++) {
      if (!visible(x, y)) continue;
      for (const [front, turned] of [[1, false], [-1, false], [1, true], [-1, true]]) {
        const [a, b, c, d] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(([i, j]) => corner(i, j, front, turned));
        indices.push(a, c, b, b, c, d);
      }
    }
    return { vertices, indices };
  };

  const crossed = tree => {
    const vertices = [], indices = [], { x, y, width, height } = tree.frame, [w, h] = tree.size_px;
    for (let card = 0; card < 3; card++) {
      const turn = card * Math.PI / 3, first = vertices.length / 7;
      for (const [px, py] of [[x, y], [x + width, y], [x, y + height], [x + width, y + height]]) {
        const mx = (px - tree.pivot_px[0]) * tree.metres_per_pixel, my = (tree.pivot_px[1] - py) * tree.metres_per_pixel;
        vertices.push(mx * Math.cos(turn), my, -mx * Math.sin(turn), px / w, py / h, turn, 1);
      }
      indices.push(first, first + 2, first + 1, first + 1, first + 2, first + 3);
    }
    return { vertices, indices };
  };

  const buffer = (kind, data) => {
    const made = gl.createBuffer();
    gl.bindBuffer(kind, made);
    gl.bufferData(kind, data, gl.STATIC_DRAW);
    return made;
  };
  const long = gl.getExtension("OES_element_index_uint");

  // The finest level of a GLB file as lists for WebGL; only what our own files hold is understood.
  const builtModel = async model => {
    const bytes = Uint8Array.from(atob(model.glb), digit => digit.charCodeAt(0));
    const length = new DataView(bytes.buffer).getUint32(12, true), start = 28 + length;
    const json = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + length)));
    const viewed = index => {
      const view = json.bufferViews[index];
      return bytes.slice(start + view.byteOffset, start + view.byteOffset + view.byteLength);
    };
    const kinds = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
    const list = index => new kinds[json.accessors[index].componentType](viewed(json.accessors[index].bufferView).buffer);
    const textures = await Promise.all(json.images.map(async image => {
      const blob = new Blob([viewed(image.bufferView)], { type: image.mimeType });
      const pixels = await createImageBitmap(blob, { premultiplyAlpha: "none", colorSpaceConversion: "none" });
      return texture(pixels);
    }));
    const node = json.nodes.find(node => node.name === model.name + "_LOD0");
    let tall = 0, wide = 0;
    const parts = json.meshes[node.mesh].primitives.map(part => {
      const material = json.materials[part.material], at = part.attributes;
      const { min, max } = json.accessors[at.POSITION];
      tall = Math.max(tall, max[1]);
      wide = Math.max(wide, max[0] - min[0]);
      const indices = list(part.indices);
      return {
        count: indices.length, long: indices instanceof Uint32Array,
        position: buffer(gl.ARRAY_BUFFER, list(at.POSITION)), uv: buffer(gl.ARRAY_BUFFER, list(at.TEXCOORD_0)),
        normal: buffer(gl.ARRAY_BUFFER, list(at.NORMAL)), indices: buffer(gl.ELEMENT_ARRAY_BUFFER, indices),
        solid: material.alphaMode === "MASK" ? 0 : 1,
        texture: textures[json.textures[material.pbrMetallicRoughness.baseColorTexture.index].source],
      };
    });
    return { parts: parts.filter(part => long || !part.long), size: [wide, tall] };
  };

  const built = async tree => {
    if (tree.glb) return builtModel(tree);
    const [albedo, normal, depth] = await Promise.all([tree.albedo, tree.normal, tree.depth].map(s => s && picture(s)));
    const mesh = depth && long ? raised(tree, albedo, depth) : crossed(tree);
    const list = long ? new Uint32Array(mesh.indices) : new Uint16Array(mesh.indices);
    return {
      tree, count: list.length,
      vertices: buffer(gl.ARRAY_BUFFER, new Float32Array(mesh.vertices)),
      indices: buffer(gl.ELEMENT_ARRAY_BUFFER, list),
      albedo: texture(albedo), normals: texture(normal), round: normal ? 1 : 0,
      size: [tree.frame.width * tree.metres_per_pixel, tree.frame.height * tree.metres_per_pixel],
    };
  };

  const ground = buffer(gl.ARRAY_BUFFER, new Float32Array([-1, 0, -1, 1, 0, -1, -1, 0, 1, 1, 0, 1].map(v => v * 1000)));

  // Perspective times a view from `distance` tree heights, column by column.
  const clipMatrix = (aspect, size) => {
    const tall = Math.max(size[1], size[0] / aspect), far = distance * tall;
    const focal = 1 / Math.tan(0.35), near = 0.02 * tall, end = 60 * tall;
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    const mid = size[1] * 0.5;
    // Rows of the view: right, up, back.
    const right = [cy, 0, -sy], up = [sy * -sp, cp, -cy * sp], back = [sy * cp, sp, cy * cp];
    const row = (v, shift) => [...v, shift];
    const view = [row(right, 0), row(up, -cp * mid), row(back, -sp * mid - far)];
    const a = (near + end) / (near - end), b = 2 * near * end / (near - end);
    const out = [];
    for (let i = 0; i < 4; i++) out.push(
      view[0][i] * focal / aspect, view[1][i] * focal,
      view[2][i] * a + (i === 3 ? b : 0), -view[2][i]);
    return new Float32Array(out);
  };

  const draw = () => {
    drawn = 0;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth * ratio | 0, canvas.clientHeight * ratio | 0];
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h);
    const color = getComputedStyle(document.body).backgroundColor.match(/[\d.]+/g).slice(0, 3).map(v => v / 255);
    gl.clearColor(...color, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!shown) return;
    gl.enable(gl.DEPTH_TEST);
    const clip = clipMatrix(w / h, shown.size);
    const sun = [Math.sin(sunYaw) * Math.cos(sunPitch), Math.sin(sunPitch), Math.cos(sunYaw) * Math.cos(sunPitch)];
    const uniform = (program, name) => gl.getUniformLocation(program, name);
    gl.useProgram(groundProgram);
    gl.bindBuffer(gl.ARRAY_BUFFER, ground);
    gl.enableVertexAttribArray(0);
    gl.disableVertexAttribArray(1);
    gl.disableVertexAttribArray(2);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.uniformMatrix4fv(uniform(groundProgram, "clip"), false, clip);
    gl.uniform3fv(uniform(groundProgram, "color"), color);
    gl.uniform3fv(uniform(groundProgram, "sun"), sun);
    gl.uniform2fv(uniform(groundProgram, "size"), shown.size);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    if (shown.parts) return drawModel(clip, sun);
    gl.useProgram(treeProgram);
    gl.bindBuffer(gl.ARRAY_BUFFER, shown.vertices);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, shown.indices);
    for (const [at, count, offset] of [[0, 3, 0], [1, 2, 12], [2, 2, 20]]) {
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, count, gl.FLOAT, false, 28, offset);
    }
    [[shown.albedo, "albedo"], [shown.normals, "normals"]].forEach(([bound, name], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, bound);
      gl.uniform1i(uniform(treeProgram, name), unit);
    });
    gl.uniformMatrix4fv(uniform(treeProgram, "clip"), false, clip);
    gl.uniform3fv(uniform(treeProgram, "sun"), sun);
    gl.uniform1f(uniform(treeProgram, "round"), shown.round);
    gl.drawElements(gl.TRIANGLES, shown.count, long ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT, 0);
  };
  const drawModel = (clip, sun) => {
    const uniform = name => gl.getUniformLocation(modelProgram, name);
    gl.useProgram(modelProgram);
    gl.enable(gl.CULL_FACE);
    gl.uniformMatrix4fv(uniform("clip"), false, clip);
    gl.uniform3fv(uniform("sun"), sun);
    gl.uniform1i(uniform("albedo"), 0);
    gl.activeTexture(gl.TEXTURE0);
    for (const part of shown.parts) {
      for (const [at, data, count] of [[0, part.position, 3], [1, part.uv, 2], [3, part.normal, 3]]) {
        gl.bindBuffer(gl.ARRAY_BUFFER, data);
        gl.enableVertexAttribArray(at);
        gl.vertexAttribPointer(at, count, gl.FLOAT, false, 0, 0);
      }
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.indices);
      gl.bindTexture(gl.TEXTURE_2D, part.texture);
      gl.uniform1f(uniform("solid"), part.solid);
      gl.drawElements(gl.TRIANGLES, part.count, part.long ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT, 0);
    }
    gl.disable(gl.CULL_FACE);
    gl.disableVertexAttribArray(3);
  };
  const redraw = () => { if (!drawn) drawn = requestAnimationFrame(draw); };

  const turn = (dx, dy, sun) => {
    if (sun) { sunYaw += dx; sunPitch = Math.min(1.4, Math.max(-0.1, sunPitch - dy)); }
    else { yaw -= dx; pitch = Math.min(1.3, Math.max(0, pitch + dy)); }
    redraw();
  };
  const zoom = factor => { distance = Math.min(8, Math.max(0.7, distance * factor)); redraw(); };
  canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", event => {
    if (event.buttons) turn(event.movementX * 0.01, event.movementY * 0.01, event.shiftKey);
  });
  canvas.addEventListener("wheel", event => { event.preventDefault(); zoom(Math.exp(event.deltaY * 0.001)); }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const steps = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    if (steps) { event.preventDefault(); turn(...steps, event.shiftKey); }
    if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 0.9 : 1.1);
  });
  new ResizeObserver(redraw).observe(canvas);

  const show = async entry => {
    for (const button of document.querySelectorAll("nav button")) button.setAttribute("aria-pressed", button.dataset.name === entry.name);
    document.getElementById("about").textContent =
      `${entry.name}: ${entry.size_m[0].toFixed(1)} × ${entry.size_m[1].toFixed(1)} m — drag to turn, wheel to come nearer, shift and drag to move the sun`;
    try {
      if (!loaded.has(entry.name)) {
        const tree = await new Promise((resolve, reject) => {
          waiting.set(entry.name, resolve);
          const script = document.createElement("script");
          script.src = entry.script;
          script.onerror = () => reject(new Error(entry.script + " cannot be read"));
          document.head.append(script);
        });
        loaded.set(entry.name, await built(tree));
      }
      shown = loaded.get(entry.name);
      document.body.dataset.shown = entry.name;
      redraw();
    } catch (error) { complain(String(error.message || error)); }
  };

  return {
    tree(tree) { waiting.get(tree.name)?.(tree); },
    trees(list) {
      const row = document.getElementById("trees");
      for (const entry of list) {
        const button = document.createElement("button"), image = new Image(), name = document.createElement("span");
        image.loading = "lazy"; image.alt = ""; image.src = entry.thumbnail;
        name.textContent = button.title = entry.name;
        button.dataset.name = entry.name;
        button.append(image, name);
        button.addEventListener("click", () => show(entry));
        row.append(button);
      }
      const wanted = decodeURIComponent(location.hash.slice(1)).split("&");
      const [name, ...turns] = wanted;
      for (const pair of turns) {
        const [key, value] = pair.split("=");
        if (key === "yaw") yaw = +value;
        if (key === "sun") sunYaw = +value;
      }
      const first = list.find(entry => entry.name === name) || list[0];
      if (first) show(first);
    },
  };
})();
