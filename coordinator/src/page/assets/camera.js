// The camera: which way a scene is seen, how near, and where on the screen a place of it lies.

class Camera {
  /** `scene` of the page's message; `canvas` gives the canvas that is drawn to. */
  constructor(scene, canvas) {
    this.scene = scene;
    this.canvas = canvas;
    this.inSpace = scene.dimensions > 2;
    this.home();
  }

  /** The whole scene, in space aslant. */
  home() {
    const { lower, upper } = this.scene;
    this.centre = lower.map((low, k) => 0.5 * (low + upper[k]));
    this.factor = 1;
    this.look(...(this.inSpace ? [-30, 22] : [0, 0]));
  }

  /** From an azimuth and an elevation [degrees]. */
  look(azimuth, elevation) {
    [this.azimuth, this.elevation] = [azimuth, elevation];
  }

  turnBy(dx, dy) {
    this.look(this.azimuth + dx, Math.max(-90, Math.min(90, this.elevation + dy)));
  }

  /** Zooms; the place at `at` [CSS px] stays where it is, by default the middle. */
  zoom(factor, at = null) {
    const before = this.view().pixels;
    this.factor = Math.max(0.2, Math.min(400, this.factor * factor));
    if (!at) return;
    const { clientWidth, clientHeight } = this.canvas();
    const grown = this.view().pixels / before - 1;
    this.move((0.5 * clientWidth - at[0]) * grown, (0.5 * clientHeight - at[1]) * grown);
  }

  /** Moves the picture by CSS pixels. */
  move(dx, dy) {
    const { turn, pixels, ratio } = this.view();
    this.centre = this.centre.map((c, k) => c - ((dx * turn[k] - dy * turn[3 + k]) * ratio) / pixels);
  }

  /** Moves a place into the middle, close up. */
  approach(position, factor) {
    this.centre = [0, 1, 2].map((k) => position[k] ?? 0);
    this.factor = factor;
  }

  /** Rows: right, up, toward the viewer. */
  turn() {
    if (!this.inSpace) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
    const up = this.scene.up_axis;
    // Two level axes a, b with a × b = up.
    const [a, b] = [(up + 1) % 3, (up + 2) % 3];
    const longer = this.scene.upper[a] - this.scene.lower[a] >= this.scene.upper[b] - this.scene.lower[b] ? 0 : 90;
    const [f, e] = [((this.azimuth + longer) * Math.PI) / 180, (this.elevation * Math.PI) / 180];
    const axis = (x, y, z) => { const v = [0, 0, 0]; v[a] = x; v[b] = y; v[up] = z; return v; };
    return [...axis(Math.cos(f), Math.sin(f), 0), ...axis(-Math.sin(f) * Math.sin(e), Math.cos(f) * Math.sin(e), Math.cos(e)), ...axis(Math.sin(f) * Math.cos(e), -Math.cos(f) * Math.cos(e), Math.sin(e))];
  }

  /** What a painter needs: `pixels` of the canvas per metre, `ratio` of them to CSS pixels, `depth` of clip space per metre. */
  view() {
    const turn = this.turn();
    const { lower, upper } = this.scene;
    const size = lower.map((low, k) => upper[k] - low);
    const half = [0, 1, 2].map((row) => [0, 1, 2].reduce((sum, k) => sum + 0.5 * Math.abs(turn[3 * row + k]) * size[k], 0));
    const { width, height, clientWidth, clientHeight } = this.canvas();
    const fit = Math.min((0.48 * width) / Math.max(half[0], 1e-12), (0.48 * height) / Math.max(half[1], 1e-12));
    const reach = Math.hypot(...size) || 1;
    return {
      turn, centre: this.centre, pixels: fit * this.factor, ratio: width / Math.max(1, clientWidth), depth: 0.4 / reach,
      middle: [0.5 * clientWidth, 0.5 * clientHeight], balls: this.inSpace,
    };
  }
}

/** Where the place (x, y, z) lies in a view of a camera [CSS px], and how near [m]. */
function projected({ turn, centre, pixels, ratio, middle }, x, y, z) {
  const [a, b, c] = [x - centre[0], y - centre[1], z - centre[2]];
  const scale = pixels / ratio;
  return [
    middle[0] + scale * (turn[0] * a + turn[1] * b + turn[2] * c),
    middle[1] - scale * (turn[3] * a + turn[4] * b + turn[5] * c),
    turn[6] * a + turn[7] * b + turn[8] * c,
  ];
}
