// The player: particles over time, drawn, turned, zoomed and picked.

const MATTERS = { fluid: "Water", solid: "Solids" };
/** A film lasts about this long [s], at most so many frames a second. */
const FILM_SECONDS = 8;
const MOST_A_SECOND = 25;

/** `?draw=webgl` and `?draw=canvas` decide, otherwise the machine. */
function wantsGl() {
  const asked = new URLSearchParams(location.search).get("draw");
  return asked ? asked === "webgl" : hasGraphicsCard();
}

class Player {
  /** `run` is the message of the page; `changed` hears of the time that is shown. */
  constructor(run, changed) {
    this.scene = run.scene;
    this.run = run;
    this.changed = changed;
    this.inSpace = this.scene.dimensions > 2;
    this.camera = new Camera(run.scene, () => this.canvas);
    this.frames = [];
    this.shown = 0;
    this.playing = false;
    this.speed = 1;
    this.picked = null;
    this.hidden = new Set();
    this.field = {};
    for (const matter of Object.keys(MATTERS)) {
      const first = this.scales(matter)[matter === "solid" ? this.scales(matter).length - 1 : 0];
      this.field[matter] = first ? first.field : "plain";
    }
    this.build();
    new ResizeObserver(() => this.fit()).observe(this.stage);
  }

  scales(matter) {
    return this.scene.scales.filter((scale) => scale.matter === matter);
  }

  scale(matter) {
    return this.scales(matter).find((scale) => scale.field === this.field[matter]);
  }

  facts(field) {
    return this.scene.fields.find((one) => one.name === field);
  }

  // ---- elements

  build() {
    this.stage = element("div", { class: "stage" });
    this.makeCanvas();
    const button = (label, text, press, extra = {}) => element("button", { type: "button", title: label, "aria-label": label, onclick: press, ...extra }, text);
    this.playButton = button("play (space)", "▶", () => this.toggle(), { class: "play" });
    this.slider = element("input", { type: "range", min: 0, max: 0, value: 0, step: 1, "aria-label": "frame", oninput: () => this.show(Number(this.slider.value), true) });
    this.clock = element("output", { class: "clock" }, "");
    this.readings = element("p", { class: "readings", role: "status", "aria-live": "polite" }, this.hint());
    const speeds = element("select", { "aria-label": "speed of the film", onchange: (event) => { this.speed = Number(event.target.value); } },
      [0.25, 0.5, 1, 2, 4].map((s) => element("option", { value: s, selected: s === 1 }, `${s}×`)));
    const groups = this.scene.groups.map((group, k) =>
      element("label", { class: "group" }, element("input", { type: "checkbox", checked: true, onchange: (event) => { this.hide(k, !event.target.checked); } }),
        element("span", { class: "dot", style: `background: ${css(PLAIN[group.matter])}` }), group.name.replaceAll("_", " ")));
    this.groupBoxes = groups.map((label) => label.querySelector("input"));
    this.bars = element("div", { class: "bars" });
    this.colouring = element("div", { class: "colouring" }, Object.entries(MATTERS).filter(([matter]) => this.scene.groups.some((g) => g.matter === matter)).map(([matter, name]) => {
      const options = [...this.scales(matter).map((scale) => [scale.field, this.facts(scale.field).label]), ["plain", "one colour"]];
      const select = element("select", { "aria-label": `colour of ${name.toLowerCase()}`, "data-matter": matter, onchange: () => { this.field[matter] = select.value; this.recolour(); } },
        options.map(([value, label]) => element("option", { value, selected: value === this.field[matter] }, label)));
      const bar = element("div", { class: "bar", "data-matter": matter });
      return element("div", { class: "colour" }, element("label", {}, `${name} by `, select), bar);
    }));
    this.view = element("div", { class: "views" },
      button("zoom in (+)", "+", () => this.zoom(1.4)), button("zoom out (−)", "−", () => this.zoom(1 / 1.4)), button("whole scene (0)", "⤢", () => this.home()),
      this.inSpace ? [button("from the side", "side", () => this.look(0, 0)), button("from above", "above", () => this.look(0, 90)), button("aslant", "aslant", () => this.home())] : null);
    this.element = element("section", { id: "player", "aria-label": "particles over time" },
      element("div", { class: "frame" }, this.stage, this.view),
      element("div", { class: "controls" }, this.playButton, this.slider, this.clock, speeds),
      this.readings, this.colouring, element("div", { class: "groups", role: "group", "aria-label": "what is shown" }, groups),
      element("p", { class: "note" }, this.notes()));
    this.drawBars();
  }

  hint() {
    const turn = this.inSpace ? "Drag to turn, with Shift to move" : "Drag to move";
    return `${turn}; pinch, or Ctrl and wheel, to zoom; press a particle to read its values.`;
  }

  notes() {
    const { run } = this;
    const columns = run.columns.filter((c) => !["x", "y", "z"].includes(c.name));
    const steps = columns.map((c) => `${this.facts(c.name).label} to ${plain((c.upper - c.lower) / ((c.bits === 8 ? 255 : 65535) - 1) / 2, this.facts(c.name).unit)}`);
    const exact = steps.length ? `Values are exact to half a step of their storage: ${steps.join(", ")}.` : "";
    const outliers = "The lowest and highest 0.5 % of all values take the end colours.";
    const thin = run.notes.length ? `Of all, ${run.notes.join("; ")}.` : "";
    return [thin, outliers, exact].filter(Boolean).join(" ");
  }

  makeCanvas(flat = !wantsGl()) {
    this.canvas?.remove();
    this.canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": "particles; space plays, arrows step, plus and minus zoom" });
    this.stage.prepend(this.canvas);
    this.painter = null;
    if (!flat) {
      try {
        this.painter = GlPainter.of(this.canvas, () => { this.makeCanvas(true); this.fit(); });
      } catch {
        // A canvas whose shaders fail has a context already.
        return this.makeCanvas(true);
      }
    }
    this.painter ??= new FlatPainter(this.canvas);
    this.canvas.dataset.painter = this.painter.name;
    this.points = null;
    this.listen();
  }

  listen() {
    const pointers = new Map();
    let moved = 0;
    const at = (event) => {
      const box = this.canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    this.canvas.addEventListener("pointerdown", (event) => { this.canvas.setPointerCapture(event.pointerId); pointers.set(event.pointerId, at(event)); moved = 0; });
    this.canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const now = at(event);
      const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const distance = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
        this.zoom(distance(now) / Math.max(1, distance(before)));
      } else if (this.inSpace && !event.shiftKey) this.turnBy(0.4 * dx, 0.4 * dy);
      else this.move(dx, dy);
      pointers.set(event.pointerId, now);
    });
    const end = (event) => {
      if (pointers.delete(event.pointerId) && moved < 5 && event.type === "pointerup") this.pick(...at(event));
    };
    this.canvas.addEventListener("pointerup", end);
    this.canvas.addEventListener("pointercancel", end);
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey && document.activeElement !== this.canvas) return;
      event.preventDefault();
      this.zoom(Math.exp(-0.0015 * event.deltaY), at(event));
    }, { passive: false });
    this.canvas.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const turning = this.inSpace && event.shiftKey;
    const actions = {
      " ": () => this.toggle(),
      ArrowLeft: () => (turning ? this.turnBy(-5, 0) : this.show(this.shown - 1, true)),
      ArrowRight: () => (turning ? this.turnBy(5, 0) : this.show(this.shown + 1, true)),
      ArrowUp: () => (turning ? this.turnBy(0, -5) : this.move(0, 30)),
      ArrowDown: () => (turning ? this.turnBy(0, 5) : this.move(0, -30)),
      Home: () => this.show(0, true),
      End: () => this.show(this.frames.length - 1, true),
      "+": () => this.zoom(1.4), "=": () => this.zoom(1.4), "-": () => this.zoom(1 / 1.4), 0: () => this.home(),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
  }

  // ---- what is seen

  home() {
    this.camera.home();
    this.draw();
  }

  look(azimuth, elevation) {
    this.camera.look(azimuth, elevation);
    this.draw();
  }

  turnBy(dx, dy) {
    this.camera.turnBy(dx, dy);
    this.draw();
  }

  zoom(factor, at = null) {
    this.camera.zoom(factor, at);
    this.draw();
  }

  move(dx, dy) {
    this.camera.move(dx, dy);
    this.draw();
  }

  /** Moves a place into the middle, close up. */
  approach(position, factor = 5) {
    this.camera.approach(position, factor);
    this.draw();
  }

  fit() {
    const { lower, upper } = this.scene;
    const width = this.stage.clientWidth;
    if (!width) return;
    const shape = this.inSpace ? 0.66 : (upper[1] - lower[1]) / Math.max(upper[0] - lower[0], 1e-12);
    const height = Math.max(180, Math.min(width * Math.max(shape, 0.3) + 8, 0.62 * window.innerHeight, 640));
    const ratio = window.devicePixelRatio || 1;
    this.canvas.style.height = `${height}px`;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.draw();
  }

  // ---- frames

  /** Takes frame `k`. */
  take(k, frame) {
    this.frames[k] = frame;
    this.slider.max = this.frames.length - 1;
    if (k === 0) this.start(frame);
    if (k === this.shown) this.show(k);
    else this.tell();
  }

  /** In space a container that holds all of the fluid would hide it. */
  start(frame) {
    if (!this.inSpace) return;
    const bounds = (wanted) => {
      const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
      ["x", "y", "z"].forEach((axis, c) => {
        const values = valuesOf(frame, axis);
        for (let i = 0; i < frame.count; i++) if (wanted(frame.groups[i])) {
          box[0][c] = Math.min(box[0][c], values[i]);
          box[1][c] = Math.max(box[1][c], values[i]);
        }
      });
      return box;
    };
    const fluid = bounds((g) => this.scene.groups[g].matter === "fluid");
    this.scene.groups.forEach((group, k) => {
      if (group.matter !== "wall") return;
      const box = bounds((g) => g === k);
      const holds = [0, 1, 2].filter((c) => box[0][c] <= fluid[0][c] && box[1][c] >= fluid[1][c]).length === 3;
      if (holds) { this.hidden.add(k); this.groupBoxes[k].checked = false; }
    });
  }

  frame() {
    return this.frames[this.shown];
  }

  show(k, byHand = false) {
    const last = this.frames.length - 1;
    const forward = k >= this.shown ? 1 : -1;
    this.shown = Math.max(0, Math.min(last, k));
    // Of a long run some frames are left out.
    while (!this.frames[this.shown] && this.shown + forward >= 0 && this.shown + forward <= last) this.shown += forward;
    if (byHand) this.follows = this.shown === last;
    this.slider.value = this.shown;
    this.points = null;
    this.draw();
    this.tell();
    const frame = this.frame();
    if (frame) this.changed(frame.time);
  }

  /** Shows the frame nearest to a time. */
  seek(time) {
    let best = 0;
    this.run.frames.forEach((frame, k) => {
      if (this.frames[k] && Math.abs(frame.time - time) < Math.abs(this.run.frames[best].time - time)) best = k;
    });
    this.show(best, true);
  }

  tell() {
    const frame = this.frame();
    if (!frame) return;
    this.clock.textContent = `t = ${seconds(frame.time)}`;
    this.slider.setAttribute("aria-valuetext", `t = ${seconds(frame.time)}, frame ${this.shown + 1} of ${this.frames.length}`);
    if (this.picked) this.read();
  }

  toggle() {
    this.playing = !this.playing;
    this.playButton.textContent = this.playing ? "⏸" : "▶";
    this.playButton.setAttribute("aria-label", this.playing ? "pause (space)" : "play (space)");
    this.playButton.title = this.playButton.getAttribute("aria-label");
    if (!this.playing) return;
    if (this.shown >= this.frames.length - 1) this.shown = -1;
    let due = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      if (now >= due) {
        const interval = Math.max(1000 / MOST_A_SECOND, (1000 * FILM_SECONDS) / Math.max(1, this.frames.length)) / this.speed;
        due = now + interval;
        if (this.shown >= this.frames.length - 1) return this.toggle();
        this.show(this.shown + 1);
      }
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  // ---- drawing

  hide(k, hidden) {
    if (hidden) this.hidden.add(k);
    else this.hidden.delete(k);
    this.recolour();
  }

  recolour() {
    this.points = null;
    this.drawBars();
    this.draw();
    if (this.picked) this.read();
  }

  prepared(frame) {
    const scales = Object.fromEntries(Object.keys(MATTERS).map((matter) => [matter, this.scale(matter)]));
    return pointsOf(frame, this.scene, scales, this.hidden);
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      const frame = this.frame();
      if (!frame || !this.canvas.width) return;
      this.points ??= this.prepared(frame);
      this.painter.paint(this.points, this.camera.view());
      this.canvas.dataset.drawn = this.points.count;
      this.mark();
    });
  }

  drawBars() {
    for (const bar of this.colouring.querySelectorAll(".bar")) {
      const scale = this.scale(bar.dataset.matter);
      bar.replaceChildren();
      if (!scale) continue;
      const { unit } = this.facts(scale.field);
      const { divisor, unit: shown } = magnitude(Math.max(Math.abs(scale.lower), Math.abs(scale.upper)), unit);
      const { marks, decimals } = ticks(scale.lower / divisor, scale.upper / divisor, 4);
      const place = (mark) => (100 * (mark * divisor - scale.lower)) / (scale.upper - scale.lower);
      bar.append(element("div", { class: "ramp", style: `background: ${gradient(mapOf(scale))}` }, marks.map((mark) => element("span", { class: Math.abs(mark) < 1e-9 ? "mark zero" : "mark", style: `left: ${place(mark)}%` }))),
        element("div", { class: "labels" }, marks.map((mark) => element("span", { style: `left: ${place(mark)}%`, class: place(mark) < 4 ? "first" : place(mark) > 96 ? "last" : "" }, fixed(mark, decimals)))),
        element("div", { class: "unit" }, `${this.facts(scale.field).label} [${shown.replace(/^·/, "")}]`));
    }
  }

  // ---- picking

  /** Where particle `i` is on the screen [CSS px], and how near [m]. */
  project(frame, i) {
    return projected(this.camera.view(), ...["x", "y", "z"].map((axis, k) => (k < this.scene.dimensions ? valueAt(frame, axis, i) : 0)));
  }

  pick(px, py) {
    const frame = this.frame();
    if (!frame) return;
    this.points ??= this.prepared(frame);
    const i = pickedOf(this.points, this.camera.view(), px, py);
    this.picked = i < 0 ? null : { group: frame.groups[i], id: frame.ids[i] };
    if (this.picked) this.read();
    else this.readings.textContent = this.hint();
    this.draw();
  }

  /** Index of the picked particle in a frame, −1 where it is not. */
  find(frame) {
    const { group, id } = this.picked;
    for (let i = 0; i < frame.count; i++) if (frame.ids[i] === id && frame.groups[i] === group) return Number.isNaN(valueAt(frame, "x", i)) ? -1 : i;
    return -1;
  }

  read() {
    const frame = this.frame();
    const i = this.find(frame);
    const group = this.scene.groups[this.picked.group];
    const name = `${group.name.replaceAll("_", " ")}, particle ${this.picked.id}`;
    if (i < 0) {
      this.readings.textContent = `${name}: not there at this time`;
      return;
    }
    const place = ["x", "y", "z"].slice(0, this.scene.dimensions).map((axis) => fixed(valueAt(frame, axis, i), 4)).join(", ");
    const values = this.scene.fields.map((f) => [f, valueAt(frame, f.name, i)]).filter(([, value]) => !Number.isNaN(value));
    this.readings.textContent = `${name} at (${place}) m: ${values.map(([f, value]) => `${f.label} ${plain(value, f.unit)}`).join(", ")}`;
  }

  /** Edges of the window in space, and rings around the picked particle and the one that ended the run. */
  mark() {
    this.stage.querySelectorAll(".ring, .edges").forEach((old) => old.remove());
    const view = this.camera.view();
    if (this.inSpace) this.stage.prepend(edgesOf(view, this.scene.lower, this.scene.upper));
    const { clientWidth, clientHeight } = this.canvas;
    const ring = ([x, y], kind, title) => {
      const radius = 9;
      if (x > -radius && y > -radius && x < clientWidth + radius && y < clientHeight + radius)
        this.stage.append(element("div", { class: `ring ${kind}`, title, style: `left: ${x - radius}px; top: ${y - radius}px` }));
    };
    const frame = this.frame();
    const i = this.picked ? this.find(frame) : -1;
    if (i >= 0) ring(this.project(frame, i), "picked", "picked");
    const { culprit } = this.run;
    if (culprit && this.shown === this.frames.length - 1)
      ring(projected(view, ...[0, 1, 2].map((k) => culprit.position[k] ?? 0)), "culprit", `particle ${culprit.id} ended the run`);
  }
}
