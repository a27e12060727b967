// Particles of a frame as points to draw and to pick, and the edges of the window around them.

/**
 * Points of a frame, in the order in which they are drawn. `scales` has a scale for each matter that is coloured by a field,
 * `hidden` the groups that are left out.
 */
function pointsOf(frame, scene, scales, hidden) {
  const inSpace = scene.dimensions > 2;
  const [x, y, z] = ["x", "y", "z"].map((axis) => valuesOf(frame, axis));
  // In the plane solids stand before water, water before walls.
  const order = ["wall", "fluid", "solid"].flatMap((matter) => [...scene.groups.keys()].filter((k) => scene.groups[k].matter === matter && !hidden.has(k)));
  const sizes = new Uint32Array(scene.groups.length);
  for (let i = 0; i < frame.count; i++) sizes[frame.groups[i]]++;
  const count = order.reduce((sum, k) => sum + sizes[k], 0);
  const points = { count, positions: new Float32Array(3 * count), colours: new Uint8Array(4 * count), diameters: new Float32Array(count), indices: new Uint32Array(count) };
  const { positions, colours, diameters, indices } = points;
  const starts = new Int32Array(sizes.length).fill(-1);
  let start = 0;
  for (const k of order) {
    starts[k] = start;
    start += sizes[k];
  }
  for (let i = 0; i < frame.count; i++) {
    const group = frame.groups[i];
    if (starts[group] >= 0) indices[starts[group]++] = i;
  }
  // What is left of thinned particles fills the same room.
  const wider = scene.every ** (1 / scene.dimensions) * (inSpace ? 1.15 : 1.38);
  const values = Object.fromEntries(Object.entries(scales).filter(([, scale]) => scale).map(([matter, scale]) => [matter, valuesOf(frame, scale.field)]));
  let at = 0;
  for (const k of order) {
    const { matter } = scene.groups[k];
    const scale = scales[matter];
    const list = values[matter];
    const table = scale ? TABLES[mapOf(scale)] : null;
    const diameter = scene.spacings[matter === "solid" ? 1 : 0] * wider;
    for (let n = 0; n < sizes[k]; n++, at++) {
      const i = indices[at];
      positions[3 * at] = x[i];
      positions[3 * at + 1] = y[i];
      positions[3 * at + 2] = inSpace ? z[i] : 0;
      let [from, c] = [PLAIN[matter], 0];
      if (scale) {
        const share = (list[i] - scale.lower) / (scale.upper - scale.lower);
        if (share === share) [from, c] = [table, 3 * Math.max(0, Math.min(255, Math.round(255 * share)))];
        else from = INVALID;
      }
      colours[4 * at] = from[c];
      colours[4 * at + 1] = from[c + 1];
      colours[4 * at + 2] = from[c + 2];
      colours[4 * at + 3] = x[i] === x[i] ? 255 : 0;
      diameters[at] = diameter;
    }
  }
  return points;
}

/** Index in its frame of the particle that a press at `[px, py]` [CSS px] means, −1 where there is none. */
function pickedOf(points, view, px, py) {
  let [best, nearest] = [-1, Infinity];
  for (let k = 0; k < points.count; k++) {
    if (!points.colours[4 * k + 3]) continue;
    const [x, y, near] = projected(view, points.positions[3 * k], points.positions[3 * k + 1], points.positions[3 * k + 2]);
    const distance = Math.hypot(x - px, y - py);
    if (distance > Math.max(6, (0.5 * points.diameters[k] * view.pixels) / view.ratio)) continue;
    // In space the foremost, in the plane the nearest.
    const rank = view.balls ? -near : distance;
    if (rank < nearest) [best, nearest] = [points.indices[k], rank];
  }
  return best;
}

/** Edges of the box from `lower` to `upper`, to see which way it is turned. */
function edgesOf(view, lower, upper) {
  const at = (corner) => projected(view, ...[0, 1, 2].map((k) => ((corner >> k) & 1 ? upper[k] : lower[k])));
  const svg = element("svg", { class: "edges", "aria-hidden": "true" });
  for (let corner = 0; corner < 8; corner++) for (const k of [0, 1, 2]) if (!((corner >> k) & 1)) {
    const [[x1, y1], [x2, y2]] = [at(corner), at(corner | (1 << k))];
    svg.append(element("line", { x1, y1, x2, y2 }));
  }
  return svg;
}
