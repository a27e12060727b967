// Draws particles as discs or shaded balls: by WebGL2 on a graphics card, or else pixel by pixel on a plain canvas.

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

/** Whether WebGL2 is there and drawn by a graphics card: by software, a plain canvas is faster. */
function hasGraphicsCard() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** Draws into the pixels of a plain canvas: discs in their order, or balls of which the nearest part is seen. */
class FlatPainter {
  constructor(canvas) {
    this.context = canvas.getContext("2d");
    this.name = "canvas";
    this.stamps = new Map();
  }

  /** Pixels of a disc: offsets, light in 256 parts, and how far it bulges toward the viewer in radii. */
  stamp(radius) {
    const key = Math.round(2 * radius);
    const known = this.stamps.get(key);
    if (known) return known;
    const r = Math.max(key / 2, 0.5);
    const [x, y, light, bulge] = [[], [], [], []];
    const reach = Math.ceil(r);
    for (let j = -reach; j <= reach; j++) for (let i = -reach; i <= reach; i++) {
      const [u, v] = [i / r, j / r];
      const q = u * u + v * v;
      if (q > 1 && !(i === 0 && j === 0)) continue;
      const w = Math.sqrt(Math.max(0, 1 - q));
      x.push(i);
      y.push(j);
      bulge.push(w);
      // The light of the shader.
      light.push(Math.min(255, 256 * (0.45 + 0.6 * Math.max(0, (-0.4 * u - 0.6 * v + 0.75 * w) / 1.04))));
    }
    const made = { x: Int16Array.from(x), y: Int16Array.from(y), light: Int16Array.from(light), bulge: Float32Array.from(bulge) };
    this.stamps.set(key, made);
    return made;
  }

  paint(points, camera) {
    const { context } = this;
    const { width, height } = context.canvas;
    if (this.image?.width !== width || this.image.height !== height) {
      this.image = context.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      this.depths = new Float32Array(width * height);
    }
    const { pixels, depths, stamps } = this;
    stamps.clear();
    pixels.fill(0);
    if (camera.balls) depths.fill(-Infinity);
    const { positions, colours, diameters } = points;
    const [t, c, s] = [camera.turn, camera.centre, camera.pixels];
    const [middleX, middleY] = [width / 2, height / 2];
    let [stamp, stampedRadius] = [null, -1];
    for (let k = 0; k < points.count; k++) {
      if (!colours[4 * k + 3]) continue;
      const x = positions[3 * k] - c[0];
      const y = positions[3 * k + 1] - c[1];
      const z = positions[3 * k + 2] - c[2];
      const px = Math.floor(middleX + s * (t[0] * x + t[1] * y + t[2] * z));
      const py = Math.floor(middleY - s * (t[3] * x + t[4] * y + t[5] * z));
      const radius = 0.5 * s * diameters[k];
      if (!(px > -radius && py > -radius && px < width + radius && py < height + radius)) continue;
      const r = colours[4 * k];
      const g = colours[4 * k + 1];
      const b = colours[4 * k + 2];
      const colour = 0xff000000 | (b << 16) | (g << 8) | r;
      if (radius !== stampedRadius) {
        stamp = this.stamp(radius);
        stampedRadius = radius;
      }
      const { x: dx, y: dy, light, bulge } = stamp;
      const near = s * (t[6] * x + t[7] * y + t[8] * z);
      for (let n = 0; n < dx.length; n++) {
        const i = px + dx[n];
        const j = py + dy[n];
        if (i < 0 || j < 0 || i >= width || j >= height) continue;
        const at = j * width + i;
        if (!camera.balls) {
          pixels[at] = colour;
          continue;
        }
        const depth = near + radius * bulge[n];
        if (depth <= depths[at]) continue;
        depths[at] = depth;
        const l = light[n];
        pixels[at] = 0xff000000 | (((b * l) >> 8) << 16) | (((g * l) >> 8) << 8) | ((r * l) >> 8);
      }
    }
    context.putImageData(this.image, 0, 0);
  }
}
