// Octahedral impostor of a tree for three.js.
//
//   import * as THREE from 'three';
//   import { impostor } from './impostor.js';
//   const record = library.crowns[0].impostors[0];        // of library.json
//   const tree = impostor(THREE, record, albedoTexture, normalTexture);
//   scene.add(tree);                                       // its origin is the tree's foot
//
// Load both textures with flipY = false; give the albedo the colour space SRGBColorSpace.
const VERTEX = `
uniform vec3 center;
uniform float halfSide;
varying vec3 place;
varying vec3 eye;
mat2x3 axesOf(vec3 d) {
  vec3 right = abs(d.y) > 0.999999 ? vec3(1.0, 0.0, 0.0) : normalize(cross(vec3(0.0, 1.0, 0.0), d));
  return mat2x3(right, cross(d, right));
}
void main() {
  eye = (inverse(modelMatrix) * vec4(cameraPosition, 1.0)).xyz - center;
  mat2x3 axes = axesOf(normalize(eye));
  place = (axes[0] * position.x + axes[1] * position.y) * 2.0 * halfSide;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(center + place, 1.0);
}`;

const FRAGMENT = `
uniform sampler2D albedoAtlas;
uniform sampler2D normalAtlas;
uniform float frames;
uniform bool fullSphere;
uniform float halfSide;
uniform float depthUnit;
uniform float cutoff;
uniform vec3 sunDirection;
uniform vec3 sunLight;
uniform vec3 skyLight;
uniform mat4 modelMatrix;
varying vec3 place;
varying vec3 eye;
mat2x3 axesOf(vec3 d) {
  vec3 right = abs(d.y) > 0.999999 ? vec3(1.0, 0.0, 0.0) : normalize(cross(vec3(0.0, 1.0, 0.0), d));
  return mat2x3(right, cross(d, right));
}
vec2 squareOf(vec3 d) {
  d /= abs(d.x) + abs(d.y) + abs(d.z);
  if (fullSphere) {
    vec2 s = vec2(d.x < 0.0 ? -1.0 : 1.0, d.z < 0.0 ? -1.0 : 1.0);
    return d.y >= 0.0 ? d.xz : (1.0 - abs(d.zx)) * s;
  }
  d.y = max(d.y, 0.0);
  d /= abs(d.x) + abs(d.y) + abs(d.z);
  return vec2(d.x + d.z, d.x - d.z);
}
vec3 directionOf(vec2 frame) {
  vec2 p = 2.0 * frame / (frames - 1.0) - 1.0;
  if (fullSphere) {
    float up = 1.0 - abs(p.x) - abs(p.y);
    vec2 s = vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    vec2 q = up >= 0.0 ? p : (1.0 - abs(p.yx)) * s;
    return normalize(vec3(q.x, up, q.y));
  }
  vec2 c = vec2(p.x + p.y, p.x - p.y) * 0.5;
  return normalize(vec3(c.x, max(1.0 - abs(c.x) - abs(c.y), 0.0), c.y));
}
// Where the ray through the place on the quad meets what a frame shows, as a place in the atlas: first
// the plane through the centre, then twice the plane at the depth that is found there.
vec2 uvOf(vec2 frame, vec3 ray, out float inside) {
  vec3 d = directionOf(frame);
  mat2x3 axes = axesOf(d);
  float along = dot(ray, d);
  along = abs(along) < 1e-4 ? 1e-4 : along;
  vec2 uv = vec2(0.5);
  float depth = 0.0;
  for (int i = 0; i < 3; i++) {
    vec3 hit = eye + ray * ((depth - dot(eye, d)) / along);
    uv = vec2(dot(hit, axes[0]), -dot(hit, axes[1])) / (2.0 * halfSide) + 0.5;
    vec2 place = (frame + clamp(uv, 0.002, 0.998)) / frames;
    depth = depthUnit * (2.0 * texture2D(normalAtlas, place).a - 1.0);
  }
  vec2 within = step(vec2(0.002), uv) * step(uv, vec2(0.998));
  inside = within.x * within.y;
  return (frame + clamp(uv, 0.002, 0.998)) / frames;
}
void main() {
  vec3 ray = normalize(place - eye);
  vec2 at = (squareOf(normalize(eye)) * 0.5 + 0.5) * (frames - 1.0);
  vec2 cell = min(floor(at), vec2(frames - 2.0));
  vec2 f = at - cell;
  vec2 third = f.x > f.y ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
  vec3 weight = vec3(1.0 - max(f.x, f.y), abs(f.x - f.y), min(f.x, f.y));
  vec3 inside;
  vec2 uv0 = uvOf(cell, ray, inside.x);
  vec2 uv1 = uvOf(cell + third, ray, inside.y);
  vec2 uv2 = uvOf(cell + 1.0, ray, inside.z);
  weight *= inside;
  vec4 a0 = texture2D(albedoAtlas, uv0);
  vec4 a1 = texture2D(albedoAtlas, uv1);
  vec4 a2 = texture2D(albedoAtlas, uv2);
  vec3 share = weight * vec3(a0.a, a1.a, a2.a);
  float alpha = share.x + share.y + share.z;
  if (alpha < cutoff) discard;
  vec3 s = share / alpha;
  vec3 albedo = a0.rgb * s.x + a1.rgb * s.y + a2.rgb * s.z;
  vec3 coded = texture2D(normalAtlas, uv0).rgb * s.x + texture2D(normalAtlas, uv1).rgb * s.y
      + texture2D(normalAtlas, uv2).rgb * s.z;
  vec3 normal = normalize(mat3(modelMatrix) * (coded * 2.0 - 1.0));
  vec3 light = sunLight * max(dot(normal, sunDirection), 0.0) + skyLight * (0.65 + 0.35 * normal.y);
  gl_FragColor = vec4(albedo * light, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;

/** A mesh that shows an impostor; `record` is an entry of `impostors` in library.json. */
export function impostor(THREE, record, albedo, normal) {
  const material = new THREE.ShaderMaterial({
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: THREE.DoubleSide,
    uniforms: {
      albedoAtlas: { value: albedo },
      normalAtlas: { value: normal },
      frames: { value: record.frames },
      fullSphere: { value: record.form === 'full' },
      center: { value: new THREE.Vector3(...record.center_m) },
      halfSide: { value: record.half_m },
      depthUnit: { value: record.depth_m },
      cutoff: { value: 0.5 },
      sunDirection: { value: new THREE.Vector3(-0.45, 0.74, 0.5).normalize() },
      sunLight: { value: new THREE.Color(1.5, 1.4, 1.25) },
      skyLight: { value: new THREE.Color(0.6, 0.68, 0.8) },
    },
  });
  const tree = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), material);
  tree.frustumCulled = false;
  return tree;
}
