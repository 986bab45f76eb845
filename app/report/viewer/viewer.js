// The operation in the page: unpacks the models that lie in it, draws them with three.js, turns, plays and colours them.
// Lengths in mm, forces in N, z up, as in the patient. Nothing is fetched; nothing runs while nothing changes.
(function () {
'use strict';

const box = document.getElementById('viewer');
const began = performance.now();
if (!box) return;
const setup = JSON.parse(document.getElementById('viewer-setup').textContent);

// ---- words and elements ----------------------------------------------------------------------------------------------

function el(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {}))
    if (name.startsWith('on')) e.addEventListener(name.slice(2), value);
    else e.setAttribute(name, value);
  e.append(...children);
  return e;
}
const clamp = (x, low, high) => Math.min(Math.max(x, low), high);
const capital = (s) => s.charAt(0).toUpperCase() + s.slice(1);
function short(x) {
  const digits = Math.abs(x) >= 100 ? 0 : Math.abs(x) >= 10 ? 1 : 2;
  return String(Number(x.toFixed(digits))).replace('-', '−').replace('.', setup.decimal);
}
/// The text in the language of the page, with values in its places {}; English where the page has no other.
function w(text, ...values) {
  let next = 0;
  return (setup.words[text] || text).replace(/\{(\d?)\}/g, (_, i) => values[i === '' ? next++ : Number(i)]);
}

// ---- the model: a packed glTF 2.0 file (app/export/page_model.h) -----------------------------------------------------

function bytesOf(base64) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(base64);  // browsers of 2025 and later, in a tenth of the time
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/// What viewer.cpp packed: gzip over the file, whose buffer views are ordered by byte and told as differences.
async function unpack(base64) {
  const packed = bytesOf(base64);
  // Not a Blob's stream, whose pieces come from another process: 2 s of them for 3 MB.
  const stream = new DecompressionStream('gzip'), into = stream.writable.getWriter(), from = stream.readable.getReader();
  const sent = into.write(packed).then(() => into.close());
  const pieces = [];
  let size = 0;
  for (let piece; !(piece = await from.read()).done; size += piece.value.length) pieces.push(piece.value);
  await sent;
  const glb = new Uint8Array(size);
  for (let i = 0, at = 0; i < pieces.length; at += pieces[i++].length) glb.set(pieces[i], at);
  const words = new DataView(glb.buffer), jsonLength = words.getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(glb.subarray(20, 20 + jsonLength)));
  return {json, bin: glb.subarray(28 + jsonLength)};
}

/// The bytes of a buffer view in their order again.
function viewOf(file, i) {
  const view = file.json.bufferViews[i], at = view.byteOffset;
  const row = view.byteStride || (view.extras && view.extras.row) || 1, rows = Math.floor(view.byteLength / row);
  const out = file.bin.slice(at, at + view.byteLength);
  for (let k = 0, from = at; k < row; ++k)
    for (let n = 0, sum = 0, to = k; n < rows; ++n, to += row) out[to] = sum = (sum + file.bin[from++]) & 255;
  return out;
}

const kArrays = {5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array};

/// The numbers of an accessor as they lie there: of places four to a vertex, the last of which is none.
function numbers(file, accessor) {
  const a = file.json.accessors[accessor];
  return new kArrays[a.componentType](viewOf(file, a.bufferView).buffer);
}

function readModel(file) {
  const told = file.json.asset.extras;
  const still = file.json.meshes.filter((mesh) => mesh.extras.still).map((mesh) => {
    const p = mesh.primitives[0];
    return {
      base: numbers(file, p.attributes.POSITION), index: numbers(file, p.indices),
      rgb: file.json.materials[p.material].pbrMetallicRoughness.baseColorFactor.slice(0, 3),
      rgba: p.attributes.COLOR_0 === undefined ? null : numbers(file, p.attributes.COLOR_0)
    };
  });
  const shapes = file.json.meshes.filter((mesh) => !mesh.extras.still).map((mesh) => {
    const first = mesh.primitives[0], named = first.attributes, about = mesh.extras;
    return {
      at: about.at, from: about.from, until: about.until, coloured: named._COLOUR !== undefined, names: about.parts,
      read: () => ({  // when it is shown first, or when nothing else is to do
        base: numbers(file, named.POSITION),
        moved: (first.targets || []).map((t) => numbers(file, t.POSITION)),
        chart: numbers(file, named.TEXCOORD_0),
        about: numbers(file, named._DEPTH_RIM_PART),
        rgba: named._COLOUR === undefined ? null : numbers(file, named._COLOUR),
        at_picture: named.TEXCOORD_1 === undefined ? null : numbers(file, named.TEXCOORD_1),
        fields: about.fields.map((row) => row.map((a) => (a === null ? null : numbers(file, a)))),
        parts: mesh.primitives.map((p, i) => ({name: about.parts[i], index: numbers(file, p.indices)}))
      })
    };
  });
  for (const frame of told.frames)
    for (const s of frame.stitches || []) s.path = evenly(s.path, 7);
  const worn = file.json.materials.find((m) => m.pbrMetallicRoughness && m.pbrMetallicRoughness.baseColorTexture);
  return {told, shapes, still, pictured: worn ? worn.name : null};  // the part that wears the picture
}

/// What lies on the skin or a face, in sizes of powers of two, which WebGL 1 can make smaller pictures of.
async function pictureOf(file) {
  const {bufferView, mimeType} = file.json.images[0];
  const as = await createImageBitmap(new Blob([viewOf(file, bufferView)], {type: mimeType}));
  const power = (n) => Math.min(2 ** Math.ceil(Math.log2(n)), 2048);
  return createImageBitmap(as, {resizeWidth: power(as.width), resizeHeight: power(as.height), resizeQuality: 'high'});
}

/// So many places at even distances on a way.
function evenly(path, n) {
  const length = [0];
  for (let i = 1; i < path.length; ++i)
    length.push(length[i - 1] + Math.hypot(...path[i].map((x, k) => x - path[i - 1][k])));
  const out = [];
  for (let i = 0, k = 0; i < n; ++i) {
    const at = length[length.length - 1] * i / (n - 1);
    while (k + 2 < length.length && length[k + 1] < at) ++k;
    const s = clamp((at - length[k]) / Math.max(length[k + 1] - length[k], 1e-9), 0, 1);
    out.push(path[k].map((x, j) => x + s * (path[k + 1][j] - x)));
  }
  return out;
}

/// Fewer triangles over the same vertices, for pictures that are gone at once: those whose corners lie in different cubes
/// of `wide` mm, a vertex of each cube and way that it faces for all. Beside a cut (`about`) all stay.
function coarser(index, base, normal, about, step, wide) {
  const first = new Map(), to = new Map(), out = [];
  const kept = (v) => {
    let w = to.get(v);
    if (w !== undefined) return w;
    if (about[4 * v + 1] < 255) return v;
    const at = (k) => Math.floor(base[4 * v + k] * step / wide), n = [0, 1, 2].map((k) => normal[3 * v + k]);
    const long = n.map(Math.abs), axis = long.indexOf(Math.max(...long));
    const key = ((at(0) * 1024 + at(1)) * 1024 + at(2)) * 8 + axis * 2 + (n[axis] > 0 ? 1 : 0);
    if (!first.has(key)) first.set(key, v);
    w = first.get(key);
    to.set(v, w);
    return w;
  };
  for (let t = 0; t < index.length; t += 3) {
    const a = kept(index[t]), b = kept(index[t + 1]), c = kept(index[t + 2]);
    if (a !== b && b !== c && c !== a) out.push(a, b, c);
  }
  return new index.constructor(out);
}
const kQuickTriangles = [9000, 24000];  // of all patients together, the least and the most, while it moves
const kQuickRatios = [0.45, 0.75];      // of pixels across
const kQuickSkin = 0.6;                 // of the triangles where skin fills the picture

// ---- looks: the light and the colours of the pictures (render/shaders.cpp) --------------------------------------------

// Light falls on vertices, which lie closer than pixels' worth of shading, so that a processor alone draws it fast.
const kVertex = `
attribute vec2 chart;
attribute vec4 about;
attribute vec4 rgba;
attribute float field;
varying vec3 v_light;
varying vec2 v_chart;
varying float v_depth, v_rim, v_field, v_shine, v_alpha;
#ifdef COLOURED
varying vec4 v_rgba;
#endif
#ifdef PICTURE
attribute vec2 at_picture;
varying vec2 v_at_picture;
#endif
uniform vec3 key_direction;
const vec3 key_colour = vec3(3.05, 2.93, 2.75), fill_colour = vec3(0.42, 0.48, 0.56);
vec3 hemisphere(vec3 n) { return mix(vec3(0.34, 0.28, 0.25), vec3(0.68, 0.67, 0.66), 0.5 + 0.5 * n.z); }
vec3 lit(vec3 n, vec3 wrap, float sky) {
  vec3 diffuse = clamp((vec3(dot(n, key_direction)) + wrap) / (1.0 + wrap), 0.0, 1.0);
  float fill = clamp(0.5 + 0.5 * dot(n, vec3(0.768, -0.329, 0.549)), 0.0, 1.0);
  return key_colour * diffuse * 0.318 + fill_colour * fill * 0.30 + hemisphere(n) * sky;
}
void main() {
  vec3 v = normalize(cameraPosition - position), n = normalize(normal + 1e-9 * v);
  float away = dot(n, v);
  n = normalize(n - 1.02 * min(away, 0.0) * v);  // towards the eye: the back of a surface is lit too
  v_chart = chart * 0.02; v_field = field; v_depth = about.x * 12.75; v_rim = about.y * 3.0;
#ifdef COLOURED
  v_rgba = rgba;
#endif
#ifdef PICTURE
  v_at_picture = at_picture;
#endif
  float toward = max(dot(n, v), 0.0);
  v_shine = pow(max(dot(n, normalize(v + key_direction)), 0.0), 24.0);
  v_alpha = mix(0.22, 0.80, pow(1.0 - toward, 2.5));
#ifdef FIELD
  v_light = vec3(0.62 + 0.30 * max(dot(n, key_direction), 0.0) + 0.12 * toward);
#else
  v_light = LIGHT;
#endif
  gl_Position = projectionMatrix * (viewMatrix * vec4(position, 1.0));
}`;

const kColours = `
varying vec3 v_light;
varying vec2 v_chart;
varying float v_depth, v_rim, v_field, v_shine, v_alpha;
#ifdef COLOURED
varying vec4 v_rgba;
#else
const vec4 v_rgba = vec4(0.0);
#endif
#ifdef PICTURE
varying vec2 v_at_picture;
uniform sampler2D picture;
#endif
uniform sampler2D colours, layers;
uniform float intervals, layer_range, clear;
vec3 to_screen(vec3 c) {
  vec3 over = max(c - 0.7, 0.0);
  c = clamp(min(c, vec3(0.7)) + 0.3 * over / (0.3 + over), 0.0, 1.0);
  vec3 r = sqrt(c);
  return 1.678 * r - 0.2027 * sqrt(r) - 0.7489 * c + 0.2736 * c * r;
}
vec3 to_linear(vec3 c) { return c * (0.0360 + c * (0.6400 + c * 0.3240)); }
// How much of a line of the grid lies on this pixel: every so many mm, of a width in mm.
float grid(float every, float wide) {
  vec2 u = v_chart / every, w = max(fwidth(u), 1e-6), d = (abs(fract(u + 0.5) - 0.5) - 0.5 * wide / every) / w;
  vec2 on = clamp(0.6 - d, 0.0, 1.0) * clamp(1.4 - 2.5 * w, 0.0, 1.0);
  return max(on.x, on.y);
}
vec3 in_colours() {
  float s = v_field * intervals, w = fwidth(s);
  vec3 c = texture2D(colours, vec2((clamp(v_field, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  float d = abs(fract(s + 0.5) - 0.5) / max(w, 1e-6);
  float line = (1.0 - smoothstep(0.4, 1.2, d)) * clamp(1.6 - 4.0 * w, 0.0, 1.0) * step(0.5, s) * step(s, intervals - 0.5);
  return mix(c, vec3(dot(c, vec3(0.3, 0.6, 0.1)) > 0.62 ? 0.0 : 1.0), 0.42 * line);
}
`;

/// Of each part: the light on it, its colour as it looks, and in the colours of a field where it has them.
const kParts = {
  skin: {
    light: 'lit(n, vec3(0.42, 0.22, 0.15), 0.27)',
    looks: `
#ifdef PICTURE
  vec3 albedo = texture2D(picture, v_at_picture).rgb;
  albedo = mix(albedo * albedo, v_rgba.rgb * v_rgba.rgb, v_rgba.a);
#else
  vec3 albedo = mix(vec3(0.74, 0.48, 0.385), v_rgba.rgb * v_rgba.rgb, v_rgba.a);
  albedo = mix(albedo, albedo * vec3(0.56, 0.45, 0.58), 0.40 * (1.0 - v_rgba.a) * grid(1.0, 0.03));
  albedo = mix(albedo, mix(vec3(0.105, 0.07, 0.22), albedo, 0.16), 0.70 * (1.0 - v_rgba.a) * grid(10.0, 0.22));
#endif
  if (v_rim < 2.97) albedo *= mix(vec3(1.0), vec3(0.97, 0.76, 0.74), exp(-v_rim * 1.1));
  albedo = mix(albedo, vec3(0.26, 0.035, 0.03), 0.85 * (1.0 - smoothstep(0.10, 0.26, v_rim)));
  gl_FragColor = vec4(to_screen(albedo * v_light + 0.10 * v_shine), 1.0);`,
    field: `
  vec3 c = mix(in_colours(), vec3(0.0), 0.16 * grid(10.0, 0.25));
  c = mix(c, vec3(0.05), 0.75 * (1.0 - smoothstep(0.10, 0.26, v_rim)));
  gl_FragColor = vec4(to_screen(to_linear(c) * v_light.x), 1.0);`
  },
  wound: {
    light: 'lit(n, vec3(0.50, 0.30, 0.22), 0.40) * mix(0.62, 1.0, exp(-v_depth / 3.2)) + 0.45 * toward',
    looks: `
  vec3 albedo = texture2D(layers, vec2(v_depth / layer_range, 0.5)).rgb;
  albedo *= albedo;
  albedo = mix(albedo, albedo * vec3(0.92, 0.45, 0.40), 0.35 * smoothstep(0.2, 0.8, v_depth));
  gl_FragColor = vec4(to_screen(albedo * v_light + 0.16 * v_shine), 1.0);`,
    field: `
  vec3 c = vec3(0.46, 0.42, 0.42) * mix(0.55, 1.0, exp(-v_depth / 3.0));
  gl_FragColor = vec4(to_screen(to_linear(c) * v_light.x), 1.0);`
  },
  side: {
    light: 'key_colour * max(dot(n, key_direction), 0.0) * 0.318 + fill_colour * 0.18 + hemisphere(n) * 0.36',
    looks: `
  vec3 layer = texture2D(layers, vec2(v_depth / layer_range, 0.5)).rgb;
  layer *= layer;
  float grey = dot(layer, vec3(0.30, 0.59, 0.11));
  vec3 albedo = mix(vec3(0.50, 0.47, 0.44) * (0.45 + 0.75 * grey), layer, 0.50) * 0.85;
  gl_FragColor = vec4(to_screen(albedo * v_light), 1.0);`
  },
  bone: {
    light: 'lit(n, vec3(0.18, 0.12, 0.08), 0.19) + 0.12 * toward',
    looks: `
  vec3 albedo = mix(vec3(0.85, 0.77, 0.62), v_rgba.rgb * v_rgba.rgb, v_rgba.a);
  if (v_rim < 2.97) albedo *= mix(vec3(1.0), vec3(0.93, 0.66, 0.58), exp(-v_rim * 1.2));
  albedo = mix(albedo, vec3(0.20, 0.05, 0.04), 0.85 * (1.0 - smoothstep(0.16, 0.42, v_rim)));
  gl_FragColor = vec4(to_screen(albedo * v_light + 0.06 * v_shine), 1.0);`
  },
  'cut bone': {
    light: 'lit(n, vec3(0.18, 0.12, 0.08), 0.19)',
    looks: 'gl_FragColor = vec4(to_screen(vec3(0.70, 0.36, 0.26) * v_light + 0.05 * v_shine), 1.0);'
  },
  face: {
    light: 'lit(n, vec3(0.42, 0.22, 0.15), 0.27)',
    looks: `
#ifdef PICTURE
  vec3 worn = texture2D(picture, v_at_picture).rgb;
#else
  vec3 worn = v_rgba.rgb;
#endif
  vec3 albedo = mix(vec3(0.72, 0.46, 0.36), worn * worn, v_rgba.a);
  gl_FragColor = vec4(to_screen(albedo * v_light + 0.08 * v_shine), mix(1.0, v_alpha, clear));`,
    field: 'gl_FragColor = vec4(to_screen(to_linear(in_colours()) * v_light.x), mix(1.0, 0.55, clear));'
  },
  things: {
    light: 'rgba.rgb * lit(n, vec3(0.2), 0.45)',
    looks: 'gl_FragColor = vec4(to_screen(v_light + 0.15 * v_shine), 1.0);'
  }
};

function look(part, uniforms, field, coloured, pictured) {
  const p = kParts[part], defines = {LIGHT: p.light};
  if (field) defines.FIELD = 1;
  if (coloured) defines.COLOURED = 1;
  if (pictured === part) defines.PICTURE = 1;
  return new THREE.ShaderMaterial({
    uniforms, defines, vertexShader: kVertex, fragmentShader: kColours + 'void main() {\n' + (field ? p.field : p.looks) + '\n}',
    extensions: {derivatives: true}, side: THREE.DoubleSide
  });
}

/// A table of colours, "rrggbb..." in hexadecimal, as a texture of one row.
function colourTable(hex) {
  const n = hex.length / 6, rgba = new Uint8Array(4 * n).fill(255);
  for (let i = 0; i < n; ++i)
    for (let k = 0; k < 3; ++k) rgba[4 * i + k] = parseInt(hex.substr(6 * i + 2 * k, 2), 16);
  const t = new THREE.DataTexture(rgba, n, 1, THREE.RGBAFormat);
  t.minFilter = t.magFilter = THREE.LinearFilter;
  t.needsUpdate = true;
  return t;
}

/// What the tissue lies against.
function stillMesh(s, told, material) {
  const n = s.base.length / 4, x = new Float32Array(3 * n), rgb = new Float32Array(3 * n);
  for (let v = 0; v < n; ++v)
    for (let k = 0; k < 3; ++k) x[3 * v + k] = told.low_mm[k] + told.step_mm * s.base[4 * v + k], rgb[3 * v + k] = s.rgba ? s.rgba[4 * v + k] / 255 : s.rgb[k];
  const g = new THREE.BufferGeometry();
  g.setAttribute('position', new THREE.BufferAttribute(x, 3));
  g.setAttribute('rgba', new THREE.BufferAttribute(rgb, 3));
  g.setIndex(new THREE.BufferAttribute(s.index, 1));
  g.computeVertexNormals();
  const mesh = new THREE.Mesh(g, material);
  mesh.frustumCulled = false;
  return mesh;
}

// ---- one patient -----------------------------------------------------------------------------------------------------

class Patient {
  constructor(model, tables) {
    this.told = model.told;
    this.shapes = model.shapes;
    this.scene = new THREE.Scene();
    this.uniforms = {
      colours: {value: tables.magnitude}, intervals: {value: 5}, clear: {value: 0},
      layers: {value: this.told.layers ? colourTable(this.told.layers.srgb) : tables.magnitude},
      layer_range: {value: this.told.layers ? this.told.layers.range_mm : 1},
      key_direction: {value: new THREE.Vector3(...(this.told.lamp || [-0.62, 0.44, 0.65])).normalize()}
    };
    const coloured = this.shapes.some((s) => s.coloured);
    if (model.pictured) this.uniforms.picture = {value: colourTable('dcb1a0')};  // until it is there
    this.looks = {};
    this.in_colours = {};
    for (const part of Object.keys(kParts)) {
      this.looks[part] = look(part, this.uniforms, false, coloured, model.pictured);
      this.in_colours[part] = kParts[part].field ? look(part, this.uniforms, true, false, null) : this.looks[part];
    }
    // What lies behind a clear face's nearest surface is not seen through it twice.
    this.veil = new THREE.MeshBasicMaterial({colorWrite: false});
    this.things = new THREE.Mesh(new THREE.BufferGeometry(), look('things', this.uniforms, false, false, null));
    this.things.frustumCulled = false;
    this.scene.add(this.things);
    for (const s of model.still) this.scene.add(stillMesh(s, this.told, this.things.material));
    this.shown = -1;
    this.field = -1;
    this.face = this.shapes.some((s) => s.names.includes('face')) ? 'clear' : null;
    this.forces = true;
  }

  pictured(image) {
    const t = new THREE.Texture(image);
    t.flipY = false;
    t.needsUpdate = true;
    this.uniforms.picture.value = t;
  }

  /// Which surface is there at a time, between which of its frames, and how far between them.
  place(at) {
    let k = 0;
    while (k + 1 < this.shapes.length && at >= this.shapes[k].until) ++k;
    const t = this.shapes[k].at;
    let f = 0;
    while (f + 2 < t.length && at >= t[f + 1]) ++f;
    const s = t.length > 1 ? clamp((at - t[f]) / (t[f + 1] - t[f]), 0, 1) : 0;
    return {shape: k, frame: f, next: Math.min(f + 1, t.length - 1), s};
  }

  built(k) {
    const shape = this.shapes[k];
    if (shape.meshes) return shape;
    Object.assign(shape, shape.read());
    const n = shape.base.length / 4;
    shape.position = new THREE.BufferAttribute(new Float32Array(3 * n), 3).setUsage(THREE.DynamicDrawUsage);
    shape.normal = new THREE.BufferAttribute(new Float32Array(3 * n), 3).setUsage(THREE.DynamicDrawUsage);
    shape.value = new THREE.BufferAttribute(new Float32Array(n), 1).setUsage(THREE.DynamicDrawUsage);
    const chart = new THREE.BufferAttribute(shape.chart, 2), about = new THREE.BufferAttribute(shape.about, 4, true);
    const rgba = new THREE.BufferAttribute(shape.rgba || new Uint8Array(4 * n), 4, true);
    const at_picture = shape.at_picture && new THREE.BufferAttribute(shape.at_picture, 2, true);
    shape.meshes = [];
    const add = (part, material, order) => {
      const g = new THREE.BufferGeometry();
      g.setAttribute('position', shape.position);
      g.setAttribute('normal', shape.normal);
      g.setAttribute('field', shape.value);
      g.setAttribute('chart', chart);
      g.setAttribute('about', about);
      g.setAttribute('rgba', rgba);
      if (at_picture) g.setAttribute('at_picture', at_picture);
      part.whole = part.whole || new THREE.BufferAttribute(part.index, 1);
      g.setIndex(part.whole);
      const mesh = new THREE.Mesh(g, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = order;
      mesh.userData.part = part.name;
      mesh.userData.of = part;
      mesh.userData.veil = material === this.veil;
      shape.meshes.push(mesh);
    };
    for (const part of shape.parts) {
      if (part.name === 'face') add(part, this.veil, 1);
      add(part, this.looks[part.name], part.name === 'face' ? 2 : 0);
    }
    return shape;
  }

  /// Fewer triangles while it moves, `most` of them or about; 0: all.
  quick(most) {
    const shape = this.shapes[this.shown];
    if (shape.parts.some((p) => p.name === 'skin')) most *= kQuickSkin;
    const all = shape.parts.reduce((n, p) => n + p.index.length / 3, 0);
    const few = most > 0 && all > most;
    if (few && shape.coarse !== most) {
      shape.coarse = most;
      // Triangles over a surface are as the square of how narrow they are.
      const n = shape.base.length / 4, size = [0, 1, 2].map((k) => { let low = 65535, high = 0; for (let v = 0; v < n; ++v) { low = Math.min(low, shape.base[4 * v + k]); high = Math.max(high, shape.base[4 * v + k]); } return (high - low) * this.told.step_mm; });
      let wide = Math.sqrt((size[0] * size[1] + size[1] * size[2] + size[2] * size[0]) * 4 / most);
      for (let tries = 0; tries < 4; ++tries, wide *= 1.3) {
        for (const p of shape.parts)
          p.few = p.name === 'wound' ? p.index : coarser(p.index, shape.base, shape.normal.array, shape.about, this.told.step_mm, wide);
        if (shape.parts.reduce((m, p) => m + p.few.length / 3, 0) < 1.15 * most) break;
      }
      for (const p of shape.parts) p.fewer = new THREE.BufferAttribute(p.few, 1);
    }
    for (const m of shape.meshes) m.geometry.index = few ? m.userData.of.fewer : m.userData.of.whole;
    return few;
  }

  show(at, most = 0) {
    const {shape: k, frame, next, s} = this.place(at);
    const shape = this.built(k), told = this.told;
    if (this.shown !== k) {
      if (this.shown >= 0) this.scene.remove(...this.shapes[this.shown].meshes);
      this.scene.add(...shape.meshes);
      this.shown = k;
    }
    const few = this.quick(most) && shape.parts[0].few;
    // Places.
    const x = shape.position.array, base = shape.base, n = base.length / 4, step = told.step_mm, low = told.low_mm;
    const a = frame > 0 ? shape.moved[frame - 1] : null, b = next > 0 ? shape.moved[next - 1] : null;
    for (let v = 0, i = 0, j = 0; v < n; ++v, j = 4 * v)
      for (let c = 0; c < 3; ++c, ++i, ++j)
        x[i] = low[c] + step * (base[j] + (a ? (1 - s) * a[j] : 0) + (b ? s * b[j] : 0));
    shape.position.needsUpdate = true;
    // Normals.
    const m = shape.normal.array.fill(0);
    for (const part of shape.parts) {
      const index = few ? part.few : part.index;
      for (let t = 0; t < index.length; t += 3) {
        const p = 3 * index[t], q = 3 * index[t + 1], r = 3 * index[t + 2];
        const ux = x[q] - x[p], uy = x[q + 1] - x[p + 1], uz = x[q + 2] - x[p + 2];
        const wx = x[r] - x[p], wy = x[r + 1] - x[p + 1], wz = x[r + 2] - x[p + 2];
        const nx = uy * wz - uz * wy, ny = uz * wx - ux * wz, nz = ux * wy - uy * wx;
        m[p] += nx, m[p + 1] += ny, m[p + 2] += nz;
        m[q] += nx, m[q + 1] += ny, m[q + 2] += nz;
        m[r] += nx, m[r + 1] += ny, m[r + 2] += nz;
      }
    }
    for (let i = 0; i < m.length; i += 3) {
      const l = Math.sqrt(m[i] * m[i] + m[i + 1] * m[i + 1] + m[i + 2] * m[i + 2]) || 1;
      m[i] /= l, m[i + 1] /= l, m[i + 2] /= l;
    }
    shape.normal.needsUpdate = true;
    // Colours.
    const fa = this.field < 0 ? null : shape.fields[frame][this.field], fb = this.field < 0 ? null : shape.fields[next][this.field];
    const looks = fa && fb ? this.in_colours : this.looks;
    if (fa && fb) {
      const value = shape.value.array;
      for (let v = 0; v < n; ++v) value[v] = ((1 - s) * fa[v] + s * fb[v]) / 255;
      shape.value.needsUpdate = true;
    }
    const clear = this.face === 'clear', face = looks.face;
    for (const mesh of shape.meshes) {
      mesh.geometry.boundingSphere = null;
      if (!mesh.userData.veil) mesh.material = looks[mesh.userData.part];
      if (mesh.userData.part === 'face') mesh.visible = clear || this.face === 'solid' && !mesh.userData.veil;
    }
    face.transparent = clear;
    face.side = clear ? THREE.FrontSide : THREE.DoubleSide;
    this.uniforms.clear.value = clear ? 1 : 0;
    this.showThings(at, k);
  }

  colourBy(field, tables) {
    this.field = field;
    if (field < 0) return;
    const f = this.told.fields[field];
    this.uniforms.colours.value = tables[f.scale];
    this.uniforms.intervals.value = f.intervals;
  }

  /// Stitches, hooks and plates at a time: those of the frame before it, moved towards the next where that has them too.
  thingsAt(at, k) {
    const frames = this.told.frames, shape = this.shapes[k];
    let f = 0;
    while (f + 1 < frames.length && frames[f + 1].at <= at) ++f;
    if (frames[f].at < shape.at[0]) ++f;  // the surface is the next one's already
    const now = frames[f], then = frames[f + 1];
    const s = then && then.at <= shape.at[shape.at.length - 1] ? clamp((at - now.at) / (then.at - now.at), 0, 1) : 0;
    const mix = (p, q) => p.map((x, i) => x + s * (q[i] - x));
    const both = (list, blend) => (now[list] || []).map((x) => {
      const y = s > 0 && (then[list] || []).find((z) => z.id === x.id);
      return y ? blend(x, y) : x;
    });
    return {
      stitches: both('stitches', (x, y) => ({...x, path: x.path.map((p, i) => mix(p, y.path[i])), force_N: x.force_N + s * (y.force_N - x.force_N)})),
      hooks: both('hooks', (x, y) => ({...x, at: mix(x.at, y.at), handle: mix(x.handle, y.handle), force_N: x.force_N + s * (y.force_N - x.force_N)})),
      plates: now.plates || []
    };
  }

  showThings(at, k) {
    const things = this.current = this.thingsAt(at, k);
    const x = [], m = [], colour = [], index = [];
    const tube = (path, radius, rgb, sides = 6) => {
      const P = path.map((p) => new THREE.Vector3(...p)), side = new THREE.Vector3();
      const first = x.length / 3;
      P.forEach((p, i) => {
        const along = P[Math.min(i + 1, P.length - 1)].clone().sub(P[Math.max(i - 1, 0)]).normalize();
        if (i === 0) side.set(Math.abs(along.x) < 0.8 ? 1 : 0, Math.abs(along.x) < 0.8 ? 0 : 1, 0);
        side.addScaledVector(along, -side.dot(along)).normalize();
        const other = along.clone().cross(side);
        for (let j = 0; j < sides; ++j) {
          const c = Math.cos(2 * Math.PI * j / sides), d = Math.sin(2 * Math.PI * j / sides);
          const nx = c * side.x + d * other.x, ny = c * side.y + d * other.y, nz = c * side.z + d * other.z;
          x.push(p.x + radius * nx, p.y + radius * ny, p.z + radius * nz);
          m.push(nx, ny, nz);
          colour.push(...rgb);
        }
      });
      for (let i = 0; i + 1 < P.length; ++i)
        for (let j = 0; j < sides; ++j) {
          const a = first + i * sides + j, b = first + i * sides + (j + 1) % sides;
          index.push(a, b, a + sides, b, b + sides, a + sides);
        }
    };
    const light = (force) => (force > setup.bad_N ? [0.72, 0.05, 0.04] : force >= setup.warn_N ? [0.85, 0.38, 0.02] : [0.04, 0.36, 0.16]);
    for (const s of things.stitches) {
      const rgb = this.forces ? light(s.force_N) : [0.03, 0.05, 0.20], up = s.up, lift = 0.25;
      const path = s.path.map((p) => p.map((c, i) => c + lift * up[i]));
      tube(path, this.forces ? 0.34 : 0.24, rgb);
      const mid = path[3];
      tube([mid.map((c, i) => c - 0.1 * up[i]), mid.map((c, i) => c + 0.9 * up[i])], 0.5, rgb);
    }
    for (const h of things.hooks) {  // the point in the tissue, and a shaft up from where it is held
      const up = h.up || [0, 0, 1], grip = h.handle.map((c, i) => c + 9 * up[i] + 2 * (c - h.at[i]));
      tube([h.at.map((c, i) => c - 0.6 * up[i]), h.handle.map((c, i) => c + 1.5 * up[i]), grip], 0.55, [0.45, 0.46, 0.50]);
    }
    for (const [a, b] of things.plates) tube([a, b], 1.1, [0.52, 0.54, 0.58], 8);
    const g = new THREE.BufferGeometry(), n = x.length / 3;
    if (n) {
      const floats = (list, size) => new THREE.BufferAttribute(new Float32Array(list), size);
      g.setAttribute('position', floats(x, 3));
      g.setAttribute('normal', floats(m, 3));
      g.setAttribute('rgba', floats(colour, 3));
      g.setIndex(new THREE.BufferAttribute(new Uint32Array(index), 1));
    }
    this.things.geometry.dispose();
    this.things.geometry = g;
    this.things.visible = n > 0;
  }

  stageTimes() { return this.told.acts.filter((a) => a.stage); }
}

// ---- the eye: turns about a place ------------------------------------------------------------------------------------

class Eye {
  constructor(told) {
    this.camera = new THREE.PerspectiveCamera(told.fov_deg, 16 / 9, 1, 5000);
    this.told = told;
    this.reset();
  }
  reset() {
    const t = this.told;
    this.up = new THREE.Vector3(...t.up).normalize();
    this.target = new THREE.Vector3(...t.target_mm);
    const way = new THREE.Vector3(...t.eye_mm).sub(this.target);
    this.distance = this.first = way.length();
    way.normalize();
    this.high = Math.asin(clamp(way.dot(this.up), -1, 1));
    // Two axes across `up`: the first points to the eye at first.
    this.ahead = way.clone().addScaledVector(this.up, -way.dot(this.up));
    if (this.ahead.length() < 1e-6) this.ahead.set(0, -1, 0);
    this.ahead.normalize();
    this.aside = this.up.clone().cross(this.ahead);
    this.round = 0;
  }
  turn(round, high) {
    this.round += round;
    this.high = clamp(this.high + high, -1.5, 1.5);
  }
  nearer(factor) { this.distance = clamp(this.distance / factor, this.first / 12, this.first * 4); }
  /// In parts of the picture's height.
  shift(right, up) {
    const high = 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360), e = this.camera.matrixWorld.elements;
    for (const [part, at] of [[-right, 0], [-up, 4]])
      this.target.add(new THREE.Vector3(e[at], e[at + 1], e[at + 2]).multiplyScalar(part * high));
  }
  look(aspect) {
    const c = this.camera, flat = Math.cos(this.high);
    c.position.copy(this.target)
      .addScaledVector(this.ahead, this.distance * flat * Math.cos(this.round))
      .addScaledVector(this.aside, this.distance * flat * Math.sin(this.round))
      .addScaledVector(this.up, this.distance * Math.sin(this.high));
    c.up.copy(this.up);
    // What is seen at first is seen in a picture that is narrower too.
    const wide = this.told.aspect;
    c.fov = aspect >= wide ? this.told.fov_deg
                           : 2 * Math.atan(Math.tan(this.told.fov_deg * Math.PI / 360) * wide / aspect) * 180 / Math.PI;
    c.aspect = aspect;
    c.near = this.distance / 50;
    c.far = this.distance * 20;
    c.lookAt(this.target);
    c.updateProjectionMatrix();
    c.updateMatrixWorld();
  }
}

/// Whether there is no graphics card: edges are not smoothed then, which would take a quarter of the time.
function drawnByProcessor() {
  const gl = document.createElement('canvas').getContext('webgl'), told = gl && gl.getExtension('WEBGL_debug_renderer_info');
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : '';
  if (gl) gl.getExtension('WEBGL_lose_context').loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// ---- the page's part -------------------------------------------------------------------------------------------------

class Viewer {
  constructor(patients, names, tables) {
    this.patients = patients;
    this.names = names;
    this.tables = tables;
    this.told = patients[0].told;
    this.eye = new Eye(this.told);
    this.at = this.told.until;
    this.playing = 0;
    this.frames = 0;
    this.gaps = [];
    this.quick_ratio = kQuickRatios[1];
    this.quick_triangles = kQuickTriangles[1];
    this.build();
    this.slow = drawnByProcessor();
    this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, antialias: !this.slow, alpha: true});
    this.renderer.debug.checkShaderErrors = false;  // each would wait for the last one; the browser's console tells of them
    this.renderer.setClearColor(0, 0);
    this.renderer.autoClear = false;
    new ResizeObserver(() => this.resize()).observe(this.stage);
    this.resize();
    this.goTo(this.at);
    this.draw();
  }

  build() {
    const told = this.told;
    this.canvas = el('canvas', {tabindex: '0', role: 'application', 'aria-label':
      w('The patient in three dimensions. Arrow keys turn, with Shift they move; plus and minus bring it nearer and farther; Home goes back to the first view; Page Up and Page Down go from act to act; the space bar plays.')});
    this.legend = el('div', {class: 'legend'});
    this.labels = el('div', {class: 'labels', 'aria-hidden': 'true'});
    this.tip = el('div', {class: 'tip', role: 'status'});
    this.stage = el('div', {class: 'stage'}, this.canvas, this.labels, this.legend, this.tip);
    if (this.names.length > 1)
      this.stage.append(...this.names.map((name, i) => el('div', {class: 'side side' + i}, el('b', {}, 'AB'[i]), ' ' + name)));
    // Time.
    this.play = el('button', {type: 'button', class: 'play', onclick: () => this.toggle()});
    this.slider = el('input', {type: 'range', min: told.from, max: told.until, step: 'any', value: this.at,
                               'aria-label': w('Time of the operation'), oninput: () => this.goTo(Number(this.slider.value), true)});
    // A key goes from act to act: steps of a slider say little.
    this.slider.addEventListener('keydown', (e) => {
      const by = {ArrowRight: 1, ArrowUp: 1, PageUp: 1, ArrowLeft: -1, ArrowDown: -1, PageDown: -1}[e.key];
      if (by) this.nextAct(by), e.preventDefault();
    });
    const length = Math.max(told.until - told.from, 1e-9), share = (at) => 100 * (at - told.from) / length;
    const ticks = el('div', {class: 'ticks', 'aria-hidden': 'true'});
    for (const a of told.acts) ticks.append(el('i', {class: a.stage ? 'stage-tick' : '', style: `left:${share(a.at).toFixed(2)}%`, title: w(a.words)}));
    this.word = el('p', {class: 'now', 'aria-live': 'off'});
    this.chips = el('div', {class: 'chips', role: 'group', 'aria-label': w('Stages')});
    this.chipOf = told.acts.filter((a) => a.stage).map((a, i) => {
      const b = el('button', {type: 'button', onclick: () => this.goTo(a.at)}, `${i + 1}. ${capital(w(a.words))}`);
      this.chips.append(b);
      return {at: a.at, b};
    });
    // What is shown.
    const choose = (label, options, chosen, change) => {
      const s = el('select', {onchange: () => change(s.value)});
      for (const [value, words] of options) s.append(el('option', value === chosen ? {value, selected: ''} : {value}, words));
      return {box: el('label', {}, label + ' ', s), select: s};
    };
    const controls = el('div', {class: 'controls'});
    this.colours = choose(w('Colours'), [['-1', w('As it looks')], ...told.fields.map((f, i) => [String(i), w(f.name)])], '-1', (v) => this.colourBy(Number(v)));
    if (told.fields.length) controls.append(this.colours.box);
    if (this.patients.some((p) => p.face))
      controls.append(choose(w('Face'), [['clear', w('see through')], ['solid', w('solid')], ['hidden', w('hidden')]], 'clear', (v) => this.showFace(v)).box);
    if (this.patients.some((p) => p.told.frames.some((f) => f.stitches))) {
      const check = el('input', {type: 'checkbox', checked: '', onchange: () => this.showForces(check.checked)});
      controls.append(el('label', {}, check, ' ' + w('Forces of the stitches')));
    }
    controls.append(el('button', {type: 'button', onclick: () => { this.eye.reset(); this.ask(); }}, w('First view')));
    box.append(this.stage, el('div', {class: 'time'}, this.play, el('div', {class: 'track'}, this.slider, ticks)), this.word, this.chips, controls,
               el('p', {class: 'note'}, w('Drag to turn, with two fingers or the right button to move, pinch or use the wheel (after a click) to come nearer. Keys: arrows, + and −, Home, Page Up and Page Down, space.')));
    this.tellPlay();
    this.listen();
  }

  listen() {
    const c = this.canvas, at = new Map();
    const spread = () => { const [p, q] = [...at.values()]; return Math.hypot(p.x - q.x, p.y - q.y); };
    c.addEventListener('pointerdown', (e) => { c.setPointerCapture(e.pointerId); at.set(e.pointerId, {x: e.clientX, y: e.clientY}); c.focus({preventScroll: true}); });
    for (const end of ['pointerup', 'pointercancel']) c.addEventListener(end, (e) => at.delete(e.pointerId));
    c.addEventListener('pointermove', (e) => {
      const p = at.get(e.pointerId);
      if (!p) return this.point(e);
      const dx = e.clientX - p.x, dy = e.clientY - p.y, high = c.clientHeight, wide = at.size === 2 ? spread() : 0;
      at.set(e.pointerId, {x: e.clientX, y: e.clientY});
      if (at.size === 2) {
        this.eye.shift(dx / high / 2, -dy / high / 2);
        this.eye.nearer(spread() / Math.max(wide, 1));
      } else if (e.buttons & 6 || e.shiftKey) this.eye.shift(dx / high, -dy / high);
      else this.eye.turn(-dx / high * 3, dy / high * 3);
      this.tip.textContent = '';
      this.ask(true);
    });
    c.addEventListener('pointerleave', () => { this.tip.textContent = ''; });
    c.addEventListener('contextmenu', (e) => e.preventDefault());
    c.addEventListener('wheel', (e) => {  // else the page is scrolled
      if (document.activeElement !== c && !e.ctrlKey) return;
      e.preventDefault();
      this.eye.nearer(Math.exp(-clamp(e.deltaY, -200, 200) * 0.0015));
      this.ask(true);
    }, {passive: false});
    c.addEventListener('keydown', (e) => {
      const step = 0.12, ways = {ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1]}[e.key];
      if (ways && e.shiftKey) this.eye.shift(-ways[0] * 0.05, ways[1] * 0.05);
      else if (ways) this.eye.turn(-ways[0] * step, ways[1] * step);
      else if (e.key === '+' || e.key === '=') this.eye.nearer(1.15);
      else if (e.key === '-') this.eye.nearer(1 / 1.15);
      else if (e.key === 'Home') this.eye.reset();
      else if (e.key === 'PageUp' || e.key === ',') this.nextAct(-1);
      else if (e.key === 'PageDown' || e.key === '.') this.nextAct(1);
      else if (e.key === ' ') this.toggle();
      else return;
      e.preventDefault();
      this.ask(true);
    });
  }

  // Time.
  goTo(at, moves = false) {
    this.at = clamp(at, this.told.from, this.told.until);
    const most = moves && this.slow ? this.quick_triangles / this.patients.length : 0;
    this.patients.forEach((p, i) => p.show(this.timeOf(i), most));
    const done = this.told.acts.filter((a) => !a.stage && a.at <= this.at + 1e-9), stages = this.told.acts.filter((a) => a.stage && a.at <= this.at + 1e-9);
    const last = done[done.length - 1], stage = stages[stages.length - 1];
    const words = (last ? capital(w(last.words)) : w('Before the first act')) + (stage ? ` · ${w(stage.words)}` : '') +
                  (this.told.unit === 's' ? ` · ${this.at.toFixed(1).replace('.', setup.decimal)} s`
                   : last ? ' · ' + w('act {} of {}', done.length, this.told.acts.filter((a) => !a.stage).length) : '');
    this.word.textContent = words;
    this.slider.value = this.at;
    this.slider.setAttribute('aria-valuetext', words);
    const here = this.chipOf.reduce((best, c) => (Math.abs(c.at - this.at) < 1e-6 ? c : best), null);
    for (const c of this.chipOf) c.b.setAttribute('aria-pressed', c === here ? 'true' : 'false');
    this.ask(moves);
  }
  /// The second operation's time: between stages of the same names in even parts; else in parts of the whole.
  timeOf(i) {
    if (i === 0) return this.at;
    const a = this.patients[0], b = this.patients[i], knots = [[a.told.from, b.told.from]];
    for (const s of a.stageTimes()) {
      const t = b.stageTimes().find((u) => u.words === s.words), last = knots[knots.length - 1];
      if (t && s.at > last[0] && t.at >= last[1]) knots.push([s.at, t.at]);
    }
    const last = knots[knots.length - 1];
    if (a.told.until > last[0]) knots.push([a.told.until, b.told.until]);
    let k = 0;
    while (k + 2 < knots.length && this.at > knots[k + 1][0]) ++k;
    const [p, q] = [knots[k], knots[k + 1] || knots[k]], s = q[0] > p[0] ? clamp((this.at - p[0]) / (q[0] - p[0]), 0, 1) : 1;
    return p[1] + s * (q[1] - p[1]);
  }
  nextAct(by) {
    const times = [...new Set([this.told.from, ...this.told.acts.map((a) => a.at), this.told.until])].sort((p, q) => p - q);
    const next = by > 0 ? times.find((t) => t > this.at + 1e-6) : times.reverse().find((t) => t < this.at - 1e-6);
    if (next !== undefined) this.goTo(next);
  }
  toggle() {
    if (this.playing) this.playing = 0;
    else {
      if (this.at >= this.told.until - 1e-6) this.goTo(this.told.from);
      const whole = this.told.until - this.told.from, lasts = clamp(this.told.unit === 's' ? whole : whole * 0.8, 6, 25);
      this.playing = whole / lasts;
      let before = performance.now();
      const next = (now) => {
        if (!this.playing) return;
        this.goTo(this.at + this.playing * Math.min((now - before) / 1000, 0.2), true);
        before = now;
        if (this.at >= this.told.until) { this.playing = 0; this.tellPlay(); }
        requestAnimationFrame(next);
      };
      requestAnimationFrame(next);
    }
    this.tellPlay();
  }
  tellPlay() { this.play.textContent = this.playing ? w('Pause') : w('Play'); }

  // Looks.
  colourBy(field) {
    const name = field < 0 ? null : this.told.fields[field].name;
    for (const p of this.patients) p.colourBy(p.told.fields.findIndex((f) => f.name === name), this.tables);
    this.colours.select.value = String(field);
    this.tellLegend(field);
    this.goTo(this.at);
  }
  showFace(how) { for (const p of this.patients) if (p.face) p.face = how; this.goTo(this.at); }
  showForces(on) { for (const p of this.patients) p.forces = on; this.goTo(this.at); }
  tellLegend(field) {
    this.legend.replaceChildren();
    this.legend.hidden = field < 0;
    if (field < 0) return;
    const f = this.told.fields[field], bar = el('div', {class: 'bar'}), hex = setup.colours[f.scale], stops = [];
    for (let i = 0; i <= 32; ++i) stops.push('#' + hex.substr(6 * Math.round(255 * i / 32), 6));
    bar.style.background = `linear-gradient(to top, ${stops.join(',')})`;
    for (let k = 0; k <= f.intervals; ++k) {
      const value = f.lo + (f.hi - f.lo) * k / f.intervals;
      const beyond = k === f.intervals && f.above ? '≥ ' : k === 0 && f.below ? '≤ ' : '';
      bar.append(el('span', {style: `bottom:${(100 * k / f.intervals).toFixed(1)}%`}, beyond + short(value)));
    }
    this.legend.append(el('b', {}, w(f.title)), el('span', {class: 'unit'}, w(f.unit)), bar);
  }

  // The picture.
  /// A new picture, with the next one of the screen. `moves`: more will follow at once, and without a graphics card this
  /// one is coarser; when no more come it is drawn again as it is.
  ask(moves = false) {
    if (moves && this.slow) {
      if (!this.moving) this.coarse(true), this.last_ms = 0;
      clearTimeout(this.moving);
      this.moving = setTimeout(() => { this.moving = 0; this.coarse(false); this.goTo(this.at); }, 200);
    }
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => {
      this.asked = false;
      if (this.moving) this.pace(now);
      this.draw();
    });
  }
  coarse(on) {
    for (const p of this.patients) p.quick(on ? this.quick_triangles / this.patients.length : 0);
    this.renderer.setPixelRatio(on ? this.quick_ratio : this.ratio());
  }
  /// Pictures that move shall come 30 times a second. Where they come more slowly they have fewer pixels, down to a fifth,
  /// then fewer triangles; more pixels again where there is time.
  pace(now) {
    if (this.last_ms) this.gaps.push(now - this.last_ms);
    this.last_ms = now;
    if (this.gaps.length < 6) return;
    const mean = this.gaps.reduce((a, b) => a + b) / this.gaps.length, was = this.quick_ratio;
    this.gaps = [];
    if (mean > 36 && was <= kQuickRatios[0]) this.quick_triangles = Math.max(this.quick_triangles * 0.7, kQuickTriangles[0]), this.coarse(true);
    else if (mean > 36) this.quick_ratio = Math.max(was * 0.82, kQuickRatios[0]);
    else if (mean < 22) this.quick_ratio = Math.min(was / 0.9, kQuickRatios[1]);
    if (this.quick_ratio !== was) this.renderer.setPixelRatio(this.quick_ratio);
  }
  ratio() { return Math.min(window.devicePixelRatio || 1, this.slow ? 1 : 2); }
  resize() {
    const w = this.stage.clientWidth, h = this.stage.clientHeight;
    if (!w || !h || !this.renderer) return;
    this.renderer.setPixelRatio(this.ratio());
    this.renderer.setSize(w, h, false);
    this.ask();
  }
  /// Where each patient is drawn, in parts of the stage: x, y from above, width, height.
  views() {
    const n = this.patients.length, flat = this.stage.clientWidth >= 560;
    return this.patients.map((_, i) => (flat ? [i / n, 0, 1 / n, 1] : [0, i / n, 1, 1 / n]));
  }
  draw() {
    const w = this.stage.clientWidth, h = this.stage.clientHeight, r = this.renderer;
    r.setScissorTest(true);
    this.views().forEach(([x, y, wide, high], i) => {
      this.eye.look(w * wide / (h * high));
      r.setViewport(w * x, h * (1 - y - high), w * wide, h * high);
      r.setScissor(w * x, h * (1 - y - high), w * wide, h * high);
      r.clear();
      r.render(this.patients[i].scene, this.eye.camera);
    });
    this.tellForces();
    if (this.frames++ === 0) {
      r.getContext().finish();
      this.first_ms = performance.now();
      box.dataset.firstPicture = Math.round(this.first_ms);
    }
  }
  /// The force of each stitch and hook beside it, the largest first; one that would cover another is left out.
  tellForces() {
    const w = this.stage.clientWidth, h = this.stage.clientHeight, taken = [], spans = this.labels.children;
    this.patients.forEach((p, i) => {
      if (!p.forces) return;
      const [x, y, wide, high] = this.views()[i], c = this.eye.camera;
      this.eye.look(w * wide / (h * high));
      const all = [...p.current.stitches.map((s) => ({at: s.path[3], up: s.up, force: s.force_N, hook: false})),
                   ...p.current.hooks.map((k) => ({at: k.handle, force: k.force_N, hook: true}))];
      for (const s of all.sort((a, b) => b.force - a.force)) {
        const place = new THREE.Vector3(...s.at), toEye = c.position.clone().sub(place);
        if (s.up && toEye.dot(new THREE.Vector3(...s.up)) < 0) continue;
        place.project(c);
        if (Math.abs(place.x) > 0.97 || Math.abs(place.y) > 0.97 || place.z > 1) continue;
        const px = w * (x + wide * (0.5 + 0.5 * place.x)), py = h * (y + high * (0.5 - 0.5 * place.y));
        if (taken.some(([a, b]) => Math.abs(a - px) < 42 && Math.abs(b - py) < 19)) continue;
        taken.push([px, py]);
        const light = s.hook ? 'hook' : s.force > setup.bad_N ? 'bad' : s.force >= setup.warn_N ? 'warn' : 'good';
        // The same elements again: new ones would be laid out anew for every picture that moves.
        const span = spans[taken.length - 1] || this.labels.appendChild(el('span')), text = `${short(s.force)} N`;
        if (span.className !== light) span.className = light;
        if (span.textContent !== text) span.textContent = text;
        span.style.transform = `translate(calc(${px.toFixed(1)}px - 50%),calc(${py.toFixed(1)}px - 145%))`;
      }
    });
    while (spans.length > taken.length) spans[spans.length - 1].remove();
  }
  /// What the colours say at the place that is pointed at.
  point(e) {
    if (this.pointed || Number(this.colours.select.value) < 0 || this.playing) return;
    this.pointed = true;
    setTimeout(() => { this.pointed = false; }, 60);
    const r = this.canvas.getBoundingClientRect(), u = (e.clientX - r.left) / r.width, v = (e.clientY - r.top) / r.height;
    this.tip.textContent = this.valueAt(u, v) || '';
  }
  valueAt(u, v) {
    const i = this.views().findIndex(([x, y, w, h]) => u >= x && u <= x + w && v >= y && v <= y + h), p = this.patients[i];
    if (!p || p.field < 0) return null;
    const [x, y, wide, high] = this.views()[i];
    this.eye.look(this.stage.clientWidth * wide / (this.stage.clientHeight * high));
    const ray = new THREE.Raycaster();
    ray.setFromCamera({x: 2 * (u - x) / wide - 1, y: 1 - 2 * (v - y) / high}, this.eye.camera);
    const shape = p.shapes[p.shown], hit = ray.intersectObjects(shape.meshes.filter((m) => m.visible && !m.userData.veil))[0];
    if (!hit || !['skin', 'face'].includes(hit.object.userData.part)) return null;
    const f = p.told.fields[p.field], value = shape.value.array[hit.face.a];
    return `${w(f.title)}: ${value >= 1 ? '≥ ' : ''}${short(f.lo + value * (f.hi - f.lo))} ${w(f.unit)}`;
  }
}

async function start() {
  const scripts = [...document.querySelectorAll('script[data-model]')];
  const patients = [], names = [], pictures = [];
  const tables = {};
  for (const [name, hex] of Object.entries(setup.colours)) tables[name] = colourTable(hex);
  for (const s of scripts) {
    const file = await unpack(s.textContent.trim()), model = readModel(file), patient = new Patient(model, tables);
    patients.push(patient);
    if (model.pictured) pictures.push(pictureOf(file).then((p) => patient.pictured(p)));  // takes a second where much is loaded
    names.push(s.dataset.model);
  }
  box.hidden = false;
  const viewer = new Viewer(patients, names, tables);
  viewer.tellLegend(-1);
  box.limberg = viewer;  // for whoever scripts the page
  await Promise.all(pictures);
  viewer.ask();
  const idle = window.requestIdleCallback || ((f) => setTimeout(f, 50));
  for (const p of patients)
    for (let k = p.shapes.length - 1; k >= 0; --k) await new Promise(idle), p.built(k);
}

start().catch((e) => {
  box.hidden = false;
  box.append(el('p', {class: 'notice', role: 'alert'}, w('This browser cannot show the model ({}); the pictures show the operation.', e.message)));
});
})();
