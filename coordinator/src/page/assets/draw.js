// Draws particles as discs or shaded balls: by WebGL2, or on a plain canvas where there is none.

const VERTEX = `#version 300 es
in vec3 position; in vec4 colour; in float diameter;
uniform mat3 turn; uniform vec3 centre; uniform vec2 scale; uniform float depth; uniform float pixels;
out vec4 shade;
void main() {
  vec3 p = turn * (position - centre);
  gl_Position = vec4(p.xy * scale, -p.z * depth, 1.0);
  gl_PointSize = max(diameter * pixels, 1.5);
  shade = colour;
  if (!(p.x * 0.0 == 0.0) || colour.a == 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
in vec4 shade; uniform bool balls; out vec4 pixel;
void main() {
  vec2 q = 2.0 * gl_PointCoord - 1.0;
  float r = dot(q, q);
  if (r > 1.0) discard;
  float light = 1.0;
  if (balls) {
    vec3 normal = vec3(q.x, -q.y, sqrt(1.0 - r));
    light = 0.45 + 0.6 * max(0.0, dot(normal, normalize(vec3(-0.4, 0.6, 0.75))));
  }
  pixel = vec4(shade.rgb * light, 1.0);
}`;

/** Draws by WebGL2. */
class GlPainter {
  static of(canvas, lost) {
    // The buffer is kept, so that pictures of the page show what is drawn.
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: true, preserveDrawingBuffer: true, premultipliedAlpha: true });
    if (!gl) return null;
    canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); lost(); });
    return new GlPainter(gl);
  }

  constructor(gl) {
    this.gl = gl;
    this.name = "WebGL2";
    const shader = (kind, text) => {
      const one = gl.createShader(kind);
      gl.shaderSource(one, text);
      gl.compileShader(one);
      return one;
    };
    const program = gl.createProgram();
    gl.attachShader(program, shader(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, shader(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    gl.useProgram(program);
    this.uniform = (name) => gl.getUniformLocation(program, name);
    this.buffers = [["position", 3, gl.FLOAT, false], ["colour", 4, gl.UNSIGNED_BYTE, true], ["diameter", 1, gl.FLOAT, false]].map(([name, size, kind, share]) => {
      const buffer = gl.createBuffer();
      const place = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, kind, share, 0, 0);
      return buffer;
    });
  }

  paint(points, camera) {
    const gl = this.gl;
    if (this.points !== points) {
      this.points = points;
      [points.positions, points.colours, points.diameters].forEach((data, k) => {
        gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[k]);
        gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
      });
    }
    const { width, height } = gl.canvas;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (camera.balls) gl.enable(gl.DEPTH_TEST);
    else gl.disable(gl.DEPTH_TEST);
    gl.uniformMatrix3fv(this.uniform("turn"), true, camera.turn);
    gl.uniform3fv(this.uniform("centre"), camera.centre);
    gl.uniform2f(this.uniform("scale"), (2 * camera.pixels) / width, (2 * camera.pixels) / height);
    gl.uniform1f(this.uniform("depth"), camera.depth);
    gl.uniform1f(this.uniform("pixels"), camera.pixels);
    gl.uniform1i(this.uniform("balls"), camera.balls ? 1 : 0);
    gl.drawArrays(gl.POINTS, 0, points.count);
  }
}

/** Draws on a plain canvas, the farthest first. */
class FlatPainter {
  constructor(canvas) {
    this.context = canvas.getContext("2d");
    this.name = "canvas";
  }

  paint(points, camera) {
    const { context } = this;
    const { width, height } = context.canvas;
    const [turn, centre, s] = [camera.turn, camera.centre, camera.pixels];
    context.clearRect(0, 0, width, height);
    let order = null;
    if (camera.balls) {
      const depth = new Float32Array(points.count);
      for (let i = 0; i < points.count; i++) {
        const [x, y, z] = [0, 1, 2].map((k) => points.positions[3 * i + k] - centre[k]);
        depth[i] = turn[6] * x + turn[7] * y + turn[8] * z;
      }
      order = Uint32Array.from({ length: points.count }, (_, i) => i).sort((a, b) => depth[a] - depth[b]);
    }
    for (let k = 0; k < points.count; k++) {
      const i = order ? order[k] : k;
      if (!points.colours[4 * i + 3]) continue;
      const x = points.positions[3 * i] - centre[0];
      const y = points.positions[3 * i + 1] - centre[1];
      const z = points.positions[3 * i + 2] - centre[2];
      const px = width / 2 + s * (turn[0] * x + turn[1] * y + turn[2] * z);
      const py = height / 2 - s * (turn[3] * x + turn[4] * y + turn[5] * z);
      const r = Math.max(0.75, 0.5 * s * points.diameters[i]);
      if (!(px > -r && px < width + r && py > -r && py < height + r)) continue;
      context.fillStyle = `rgb(${points.colours[4 * i]},${points.colours[4 * i + 1]},${points.colours[4 * i + 2]})`;
      if (r < 2) {
        context.fillRect(px - r, py - r, 2 * r, 2 * r);
      } else {
        context.beginPath();
        context.arc(px, py, r, 0, 2 * Math.PI);
        context.fill();
        if (camera.balls) {
          context.strokeStyle = "rgba(0, 0, 0, 0.35)";
          context.stroke();
        }
      }
    }
  }
}
