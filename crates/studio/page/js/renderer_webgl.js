// Draws layers of meshes with WebGL.

import { STRIDE } from "./mesh.js";

const VERTEX = `
attribute vec3 place;
attribute vec4 color;
uniform mat4 clipFromWorld;
uniform float size;
varying vec4 shade;
void main() {
  gl_Position = clipFromWorld * vec4(place, 1.0);
  gl_PointSize = size;
  shade = color;
}`;
const FRAGMENT = `
precision mediump float;
varying vec4 shade;
void main() { gl_FragColor = vec4(shade.rgb * shade.a, shade.a); }`;

/** Names of renderers that have no graphics card below them; not all browsers tell of them as a performance caveat. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

export class WebGlRenderer {
  /** Null if there is no WebGL, or only one in software, unless that is wished for: a 2D canvas is faster then. */
  static create(canvas, isSoftwareFine) {
    const options = { alpha: false, premultipliedAlpha: true, antialias: true };
    // Tried on another canvas: one that has been asked for WebGL gives no other context.
    if (!isSoftwareFine && !hasCard({ ...options, failIfMajorPerformanceCaveat: true })) return null;
    const gl = canvas.getContext("webgl", options);
    return gl ? new WebGlRenderer(canvas, gl) : null;
  }

  constructor(canvas, gl) {
    this.name = "WebGL";
    this.canvas = canvas;
    this.gl = gl;
    this.prepare();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.prepare());
  }

  prepare() {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    this.program = program;
    this.at = {
      place: gl.getAttribLocation(program, "place"),
      color: gl.getAttribLocation(program, "color"),
      clipFromWorld: gl.getUniformLocation(program, "clipFromWorld"),
      size: gl.getUniformLocation(program, "size"),
    };
    this.buffers = new WeakMap();
  }

  /** `layers`: `{mesh, kind: "triangles" | "lines" | "points", isFlat, size}`; flat ones do not hide each other. */
  draw(clipFromWorld, background, layers) {
    const { gl, canvas } = this;
    if (gl.isContextLost()) return;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(background[0], background[1], background[2], 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(this.at.clipFromWorld, false, clipFromWorld);
    const kinds = { triangles: gl.TRIANGLES, lines: gl.LINES, points: gl.POINTS };
    for (const layer of layers) {
      if (layer.mesh.count === 0) continue;
      this.bind(layer.mesh);
      gl.depthMask(!layer.isFlat);
      gl.uniform1f(this.at.size, layer.size ?? 1);
      gl.drawArrays(kinds[layer.kind ?? "triangles"], 0, layer.mesh.count);
    }
    gl.depthMask(true);
  }

  bind(mesh) {
    const { gl } = this;
    let known = this.buffers.get(mesh);
    if (!known) {
      known = { buffer: gl.createBuffer(), version: -1 };
      this.buffers.set(mesh, known);
    }
    gl.bindBuffer(gl.ARRAY_BUFFER, known.buffer);
    if (known.version !== mesh.version) {
      gl.bufferData(gl.ARRAY_BUFFER, mesh.data.subarray(0, mesh.count * STRIDE), gl.DYNAMIC_DRAW);
      known.version = mesh.version;
    }
    gl.enableVertexAttribArray(this.at.place);
    gl.enableVertexAttribArray(this.at.color);
    gl.vertexAttribPointer(this.at.place, 3, gl.FLOAT, false, 4 * STRIDE, 0);
    gl.vertexAttribPointer(this.at.color, 4, gl.FLOAT, false, 4 * STRIDE, 12);
  }
}

/** Whether WebGL runs on a graphics card, as far as the browser tells. */
function hasCard(options) {
  const gl = document.createElement("canvas").getContext("webgl", options);
  if (!gl) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(info?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER);
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return !SOFTWARE.test(name);
}
