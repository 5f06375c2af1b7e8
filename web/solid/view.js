// The part in 3D, by WebGL: its surface in the colours of the map's layer, the tip's path, places, and the tool at the pointer. Loaded only
// when it is asked for.

import { PLACES } from '../part/overlays.js';
import { Camera, Geometry, Mesh, Orbit, Program, Renderer, Transform, Vec3 } from '../vendor/ogl/ogl.min.js';
import { facetsOfStl, frameOf, isBinaryStl, linesOf, piecesOfStl, pointsOf, surfaceOfMap, toolOf } from './geometry.js';

const VERTEX = `#version 300 es
in vec3 position;
in vec4 colour;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float size;
out vec3 seen;
out vec4 tint;
void main() {
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  seen = at.xyz;
  tint = colour;
  gl_PointSize = size;
  gl_Position = projectionMatrix * at;
}`;
// Facets are lit by the angle of their normal to the line of sight, mildly, so that the colours stay those of the legend.
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 seen;
in vec4 tint;
uniform float lit;
uniform float opacity;
uniform float size;
out vec4 shown;
void main() {
  // Places are round.
  if (size > 4.0 && length(gl_PointCoord - vec2(0.5)) > 0.5) discard;
  // Points and lines have no normal.
  float light = lit > 0.5 ? 0.62 + 0.38 * abs(dot(normalize(cross(dFdx(seen), dFdy(seen))), normalize(seen))) : 1.0;
  shown = vec4(tint.rgb * light, opacity);
}`;
const [TURN, ZOOM] = [0.12, 1.15];
// The most facets that are drawn where the processor does a graphics card's work: with more, a frame takes longer than 0.1 s.
const MOST_BY_PROCESSOR = 40_000;
// Frames for the orbit to come to rest after a move.
const SETTLES = 45;

/** Whether the browser can show the view. */
export const isPossible = () => document.createElement('canvas').getContext('webgl2') !== null;

// Whether the processor does the graphics card's work, by the names of the common programs that do it.
function isByProcessor() {
  const gl = document.createElement('canvas').getContext('webgl2', { failIfMajorPerformanceCaveat: true });
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  return !gl || /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}

export class SolidView {
  element;
  #renderer;
  #gl;
  #camera;
  #orbit;
  #scene = new Transform();
  // Meshes by their part of the scene.
  #parts = {};
  #programs = new Map();
  #frame = null;
  #shown = null;
  #left = 0;
  #isDue = false;
  #at = 0;
  #onTool;
  #version = 0;
  #isByProcessor = isByProcessor();
  /** Whether the map's cells are drawn as the surface because the file's facets would take too long. */
  isCoarse = false;

  /** `onTool(cell, move)` is called with the cell of the map under the pointer and the index of the nearest move of the path; both may be null. */
  constructor(canvas, onTool) {
    this.element = canvas;
    this.#onTool = onTool;
    this.#renderer = new Renderer({ canvas, dpr: Math.min(2, globalThis.devicePixelRatio || 1), alpha: true, antialias: !this.#isByProcessor, preserveDrawingBuffer: true, webgl: 2 });
    this.#gl = this.#renderer.gl;
    // The surface stands back, so that the path on it is seen.
    this.#gl.enable(this.#gl.POLYGON_OFFSET_FILL);
    this.#gl.polygonOffset(1.5, 1.5);
    this.#camera = new Camera(this.#gl, { fov: 35 });
    for (const event of ['mousedown', 'wheel', 'touchstart', 'touchmove']) canvas.addEventListener(event, () => this.#wake(), { passive: true });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons) this.#wake();
      else this.#pointAt(event);
    });
    canvas.addEventListener('keydown', (event) => this.#key(event));
  }

  resize(width, height) {
    this.#renderer.setSize(width, height);
    this.#camera.perspective({ aspect: width / height });
    this.#wake();
  }

  /** Shows {map, colourOf, path?, tips?, places?, cutter?, file?: {bytes, unit}}: `path` is drawn, `tips` is the path along which the tool moves. The camera stays for the same map. */
  async show(shown) {
    const version = (this.#version += 1);
    const isSame = this.#shown?.map === shown.map;
    this.#shown = shown;
    if (!isSame) this.#look(frameOf(shown.map));
    const { map, colourOf, path, places, cutter, file } = shown;
    this.#put('surface', [surfaceOfMap(map, this.#frame, colourOf, this.#isByProcessor && 2 * map.z_mm.length > MOST_BY_PROCESSOR ? 2 : 1)], { lit: 1 });
    this.#put('path', path ? [linesOf(path, this.#frame)] : [], { mode: this.#gl.LINES });
    this.#put('places', places?.length ? [pointsOf(places, PLACES, this.#frame)] : [], { mode: this.#gl.POINTS, size: 11 });
    this.#put('tool', cutter?.type ? [toolOf(cutter)] : [], { lit: 1, opacity: 0.55 });
    if (this.#tool) this.#tool.visible = false;
    const isStl = file && isBinaryStl(file.bytes);
    this.isCoarse = isStl && this.#isByProcessor && facetsOfStl(file.bytes) > MOST_BY_PROCESSOR;
    this.#wake();
    if (isStl && !this.isCoarse) await this.#showFacets(file, version);
  }

  // The file's own facets take the place of the raster once they are all there.
  async #showFacets({ bytes, unit }, version) {
    const { map, colourOf } = this.#shown;
    const pieces = [];
    for await (const piece of piecesOfStl(bytes, unit, map, this.#frame, colourOf, 2 * map.cell_mm)) {
      if (version !== this.#version) return pieces.forEach((mesh) => mesh.geometry.remove());
      pieces.push(this.#mesh(piece, { lit: 1 }));
    }
    this.#remove('surface');
    this.#parts.surface = pieces;
    for (const piece of pieces) piece.setParent(this.#scene);
    return this.#wake();
  }

  get #tool() {
    return this.#parts.tool?.[0];
  }

  #remove(name) {
    for (const mesh of this.#parts[name] ?? []) {
      mesh.setParent(null);
      mesh.geometry.remove();
    }
  }

  // Replaces a part of the scene.
  #put(name, contents, options) {
    this.#remove(name);
    this.#parts[name] = contents.map((content) => this.#mesh(content, options));
    for (const mesh of this.#parts[name]) mesh.setParent(this.#scene);
  }

  #mesh(content, { mode = this.#gl.TRIANGLES, lit = 0, opacity = 1, size = 1 }) {
    const { position, colour, index } = content;
    const geometry = new Geometry(this.#gl, { position: { size: 3, data: position }, colour: { size: 4, data: colour, type: this.#gl.UNSIGNED_BYTE, normalized: true }, ...(index && { index: { data: index } }) });
    return new Mesh(this.#gl, { geometry, program: this.#program(lit, opacity, size), mode, frustumCulled: false });
  }

  // Programs are compiled once for each kind of part.
  #program(lit, opacity, size) {
    const kind = `${lit} ${opacity} ${size}`;
    if (!this.#programs.has(kind)) this.#programs.set(kind, new Program(this.#gl, { vertex: VERTEX, fragment: FRAGMENT, uniforms: { lit: { value: lit }, opacity: { value: opacity }, size: { value: size * this.#renderer.dpr } }, cullFace: false, transparent: opacity < 1 }));
    return this.#programs.get(kind);
  }

  // Puts the camera at the usual place before a part: from the front, above.
  #look(frame) {
    this.#frame = frame;
    const { reach } = frame;
    this.#camera.near = reach / 200;
    this.#camera.far = reach * 60;
    this.#camera.position.set(reach * 0.65, reach * 1.65, reach * 1.75);
    this.#camera.lookAt([0, 0, 0]);
    this.#camera.perspective();
    this.#orbit?.remove();
    this.#orbit = new Orbit(this.#camera, { element: this.element, target: new Vec3(0, 0, 0), ease: 0.4, inertia: 0.6, rotateSpeed: 0.25, minDistance: reach / 20, maxDistance: reach * 12 });
  }

  // Draws until the orbit is at rest.
  #wake() {
    this.#left = SETTLES;
    this.#redraw();
  }

  #redraw() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => {
      this.#isDue = false;
      this.#left = Math.max(0, this.#left - 1);
      this.#orbit?.update();
      this.#renderer.render({ scene: this.#scene, camera: this.#camera });
      if (this.#left > 0) this.#redraw();
    });
  }

  #key(event) {
    const turns = { ArrowLeft: [-TURN, 0], ArrowRight: [TURN, 0], ArrowUp: [0, -TURN], ArrowDown: [0, TURN] }[event.key];
    const zoom = { '+': 1 / ZOOM, '=': 1 / ZOOM, '-': ZOOM }[event.key];
    const step = { PageUp: -1, PageDown: 1 }[event.key];
    if (!turns && !zoom && !step) return;
    event.preventDefault();
    if (step) return void this.#moveTool(this.#at + step * (event.shiftKey ? 50 : 1));
    const { position } = this.#camera;
    const radius = Math.hypot(position.x, position.y, position.z) * (zoom ?? 1);
    const [azimuth, polar] = [Math.atan2(position.x, position.z) + (turns?.[0] ?? 0), Math.acos(position.y / Math.hypot(position.x, position.y, position.z)) + (turns?.[1] ?? 0)];
    const down = Math.min(Math.PI - 0.05, Math.max(0.05, polar));
    position.set(radius * Math.sin(down) * Math.sin(azimuth), radius * Math.cos(down), radius * Math.sin(down) * Math.cos(azimuth));
    this.#camera.lookAt([0, 0, 0]);
    this.#orbit.forcePosition();
    this.#wake();
  }

  // The cell of the map under the pointer: the first on the line of sight whose surface is over the line.
  #cellAt(event) {
    const box = this.element.getBoundingClientRect();
    const [u, v] = [(2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height];
    const [near, far] = [-1, 1].map((depth) => {
      const point = new Vec3(u, v, depth);
      this.#camera.unproject(point);
      return point;
    });
    const { columns, rows, cell_mm: cell, origin_mm: origin, z_mm: z } = this.#shown.map;
    const { x, y, z: middle, reach } = this.#frame;
    const direction = far.sub(near).normalize();
    const distance = near.len();
    for (let t = Math.max(0, distance - 1.2 * reach); t < distance + 1.2 * reach; t += cell / 2) {
      const at = [near.x + t * direction.x, near.y + t * direction.y, near.z + t * direction.z];
      const [column, row] = [Math.floor((at[0] + x - origin[0]) / cell), Math.floor((y - at[2] - origin[1]) / cell)];
      if (column < 0 || row < 0 || column >= columns || row >= rows) continue;
      const height = z[row * columns + column];
      if (height !== null && at[1] + middle <= height) return { column, row };
    }
    return null;
  }

  #pointAt(event) {
    if (!this.#shown) return;
    const cell = this.#cellAt(event);
    const { tips: path, map } = this.#shown;
    if (!cell || !path) return void this.#onTool(cell, null);
    const [x, y] = [map.origin_mm[0] + (cell.column + 0.5) * map.cell_mm, map.origin_mm[1] + (cell.row + 0.5) * map.cell_mm];
    let [best, least] = [-1, Infinity];
    for (let i = 0; i < path.count; i += 1) {
      const distance = (path.x[i] - x) ** 2 + (path.y[i] - y) ** 2;
      if (path.isRapid[i] || distance >= least) continue;
      [best, least] = [i, distance];
    }
    if (best >= 0) this.#moveTool(best, cell);
  }

  // Puts the tool at a move of the path.
  #moveTool(move, cell = null) {
    const { tips: path } = this.#shown ?? {};
    if (!path || path.count === 0) return;
    this.#at = Math.min(path.count - 1, Math.max(0, move));
    const tool = this.#tool;
    if (tool) {
      tool.visible = true;
      tool.position.set(path.x[this.#at] - this.#frame.x, path.z[this.#at] - this.#frame.z, this.#frame.y - path.y[this.#at]);
      this.#redraw();
    }
    this.#onTool(cell, this.#at);
  }
}
