// Lines over time, all on one axis of time, with the cursor at the time of the player.

const PLOT_HEIGHT = 190;
const MARGIN = { left: 56, right: 12, top: 10, bottom: 24 };

class Plots {
  /** `seek` is called with the time that is pressed. */
  constructor(seek) {
    this.seek = seek;
    this.drawn = [];
    this.range = null;
    this.time = null;
    this.open = {};
    this.filter = element("input", { type: "search", placeholder: "find a plot, such as force", "aria-label": "find a plot", oninput: () => this.apply() });
    this.whole = element("button", { type: "button", hidden: true, onclick: () => this.select(null) }, "whole time");
    this.body = element("div");
    this.element = element("section", { id: "plots", "aria-label": "quantities over time" },
      element("div", { class: "head" }, element("h2", {}, "Over time"), this.filter, this.whole),
      element("p", { class: "note" }, "One axis of time for all. Move over a plot to read values, press to see the particles at that time, drag to look closer."), this.body);
    // A plot is drawn when it comes near to the screen.
    this.near = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        const one = this.drawn.find(({ figure }) => figure === target);
        if (!one) continue;
        one.near = isIntersecting;
        this.drawIfNear(one);
      }
      this.cursor(this.time);
    }, { rootMargin: "100%" });
    addEventListener("beforeprint", () => { for (const one of this.drawn) if (one.holder.clientWidth) this.draw(one); });
    let width = 0;
    new ResizeObserver(() => {
      if (Math.abs(this.body.clientWidth - width) < 2) return;
      width = this.body.clientWidth;
      this.drawAll();
    }).observe(this.body);
  }

  /** Takes the groups of plots of a message. */
  take(groups) {
    this.groups = groups;
    for (const details of this.body.querySelectorAll("details")) this.open[details.id] = details.open;
    this.near.disconnect();
    const near = new Set(this.drawn.filter((one) => one.near).map((one) => one.figure.dataset.title));
    this.drawn = [];
    this.body.replaceChildren(...groups.map((group, k) => {
      const figures = group.plots.map((plot) => {
        const legend = element("span", { class: "keys" });
        const peak = element("span", { class: "peak" }, this.peak(plot));
        const holder = element("div", { class: "plot" });
        const title = `${plot.title} ${group.headline}`.toLowerCase();
        const figure = element("figure", { "data-title": title }, element("figcaption", {}, element("b", {}, plot.title), legend, peak), holder);
        this.drawn.push({ plot, figure, legend, holder, near: near.has(title) });
        return figure;
      });
      const details = element("details", { id: `plots-${group.id}`, open: this.open[`plots-${group.id}`] ?? k < (innerWidth < 700 ? 1 : 2), ontoggle: () => { if (details.open) this.drawAll(); } },
        element("summary", {}, element("h3", {}, `${group.headline} `, element("span", { class: "count" }, `${group.plots.length}`))), group.note ? element("p", { class: "note" }, group.note) : null, element("div", { class: "figures" }, figures));
      return details;
    }));
    for (const { figure } of this.drawn) this.near.observe(figure);
    this.apply();
  }

  /** Largest and smallest value in words. */
  peak(plot) {
    const texts = [];
    for (const [word, better] of [["largest", (a, b) => a > b], ["smallest", (a, b) => a < b]]) {
      let best = null;
      plot.lines.forEach((line) => line.values.forEach((value, i) => { if (value !== null && (!best || better(value, best.value))) best = { value, i, line }; }));
      if (best) texts.push(`${word} ${plain(best.value, plot.unit)}${plot.lines.length > 1 ? ` (${best.line.name})` : ""} at ${seconds(plot.times[best.i])}`);
    }
    return plot.logarithmic ? texts[0] ?? "exactly zero" : texts.join(", ");
  }

  apply() {
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { figure } of this.drawn) figure.hidden = !words.every((word) => figure.dataset.title.includes(word));
    for (const details of this.body.children) {
      const any = details.querySelector("figure:not([hidden])");
      details.hidden = !any;
      if (words.length && any) details.open = true;
    }
    this.drawAll();
  }

  select(range) {
    this.range = range;
    this.whole.hidden = !range;
    this.drawAll();
  }

  drawAll() {
    for (const one of this.drawn) {
      one.stale = true;
      this.drawIfNear(one);
    }
    this.cursor(this.time);
  }

  drawIfNear(one) {
    if (!one.stale || !one.near || !one.holder.clientWidth) return;
    one.stale = false;
    this.draw(one);
  }

  draw(one) {
    const { plot, holder } = one;
    const width = holder.clientWidth;
    const ends = [plot.times[0] ?? 0, plot.times[plot.times.length - 1] ?? 1];
    const [from, to] = this.range ?? [ends[0], ends[1] > ends[0] ? ends[1] : ends[0] + 1];
    const inside = plot.times.map((t, i) => (t >= from && t <= to ? i : -1)).filter((i) => i >= 0);
    const drawable = (v) => v !== null && (!plot.logarithmic || v > 0);
    let [low, high] = [Infinity, -Infinity];
    for (const line of plot.lines) for (const i of inside) if (drawable(line.values[i])) { low = Math.min(low, line.values[i]); high = Math.max(high, line.values[i]); }
    if (!(low <= high)) {
      holder.replaceChildren(element("p", { class: "none" }, plot.logarithmic ? "exactly zero at every half-step" : "no value at this time"));
      one.x = null;
      return;
    }
    let shape = (v) => v;
    let marks;
    if (plot.logarithmic) {
      if (plot.level) high = Math.max(high, plot.level);
      [low, high] = [Math.floor(Math.log10(low)), Math.max(Math.ceil(Math.log10(high)), Math.floor(Math.log10(low)) + 1)];
      shape = Math.log10;
      const step = Math.ceil((high - low) / 4);
      marks = [];
      for (let d = high; d >= low; d -= step) marks.push([d, `10${superscript(d)}`]);
      one.unit = plot.unit;
    } else {
      if (high - low <= 1e-9 * Math.max(Math.abs(low), Math.abs(high))) { const room = 0.1 * Math.abs(high) || 1; low -= room; high += room; }
      const room = 0.06 * (high - low);
      [low, high] = [low - room, high + room];
      const size = magnitude(Math.max(Math.abs(low), Math.abs(high)), plot.unit);
      const { marks: list, decimals } = ticks(low / size.divisor, high / size.divisor, 4);
      marks = list.map((mark) => [mark * size.divisor, fixed(mark, decimals)]);
      one.unit = size.unit;
    }
    const [right, bottom] = [width - MARGIN.right, PLOT_HEIGHT - MARGIN.bottom];
    const x = (t) => MARGIN.left + ((t - from) / (to - from)) * (right - MARGIN.left);
    const y = (v) => bottom - ((shape(v) - low) / (high - low)) * (bottom - MARGIN.top);
    const place = (v) => bottom - ((v - low) / (high - low)) * (bottom - MARGIN.top);
    const svg = element("svg", { viewBox: `0 0 ${width} ${PLOT_HEIGHT}`, width, height: PLOT_HEIGHT, role: "img", tabindex: 0, "aria-label": `${plot.title}: ${this.peak(plot)}` });
    svg.append(element("title", {}, `${plot.title}: ${this.peak(plot)}`));
    for (const [value, text] of marks) {
      svg.append(element("line", { class: Math.abs(value) < 1e-12 * (high - low) && !plot.logarithmic ? "zero" : "grid", x1: MARGIN.left, x2: right, y1: place(value), y2: place(value) }),
        element("text", { x: MARGIN.left - 6, y: place(value) + 4, "text-anchor": "end" }, text));
    }
    const { marks: times, decimals } = ticks(from, to, Math.max(3, Math.min(7, width / 90)));
    for (const t of times) svg.append(element("line", { class: "axis", x1: x(t), x2: x(t), y1: bottom, y2: bottom + 4 }), element("text", { x: x(t), y: bottom + 18, "text-anchor": x(t) > right - 20 ? "end" : "middle" }, fixed(t, decimals)));
    svg.append(element("line", { class: "axis", x1: MARGIN.left, x2: right, y1: bottom, y2: bottom }));
    if (one.unit) svg.append(element("text", { class: "unit", x: MARGIN.left + 4, y: MARGIN.top + 8 }, `[${one.unit.replace(/^·/, "")}]`));
    svg.append(element("text", { class: "unit", x: right, y: bottom - 5, "text-anchor": "end" }, "t [s]"));
    if (plot.level) svg.append(element("line", { class: "level", x1: MARGIN.left, x2: right, y1: y(plot.level), y2: y(plot.level) }));
    plot.lines.forEach((line, k) => {
      let path = "";
      let pen = false;
      for (const i of inside) {
        const value = line.values[i];
        // Zero is no point of a logarithmic axis, and no end of a line either.
        if (plot.logarithmic && value === 0) continue;
        if (!drawable(value)) { pen = false; continue; }
        path += `${pen ? "L" : "M"}${x(plot.times[i]).toFixed(1)} ${y(value).toFixed(1)}`;
        pen = true;
      }
      if (!path.includes("L") && path) path += "h2";
      svg.append(element("path", { d: path, stroke: LINE_COLOURS[k % LINE_COLOURS.length], "stroke-dasharray": k >= LINE_COLOURS.length ? "4 3" : null }));
    });
    if (!plot.logarithmic) this.dots(svg, plot, inside, x, y);
    one.line = element("line", { class: "cursor", y1: MARGIN.top, y2: bottom });
    one.band = element("rect", { class: "band", y: MARGIN.top, height: bottom - MARGIN.top, width: 0, x: 0 });
    svg.append(one.band, one.line);
    Object.assign(one, { x, from, to });
    this.listen(svg, one, right);
    holder.replaceChildren(svg);
  }

  /** Dots at the largest and smallest value. */
  dots(svg, plot, inside, x, y) {
    for (const sign of [1, -1]) {
      let best = null;
      plot.lines.forEach((line, k) => inside.forEach((i) => { const v = line.values[i]; if (v !== null && (!best || sign * v > sign * best.v)) best = { v, i, k }; }));
      if (best) svg.append(element("circle", { cx: x(plot.times[best.i]), cy: y(best.v), r: 3, fill: LINE_COLOURS[best.k % LINE_COLOURS.length] }, element("title", {}, `${plain(best.v, plot.unit)} at ${seconds(plot.times[best.i])}`)));
    }
  }

  listen(svg, one, right) {
    let start = null;
    const timeOf = (event) => {
      const px = event.clientX - svg.getBoundingClientRect().left;
      return one.from + (Math.max(0, Math.min(1, (px - MARGIN.left) / (right - MARGIN.left)))) * (one.to - one.from);
    };
    svg.addEventListener("pointermove", (event) => {
      const t = timeOf(event);
      this.cursor(t, true);
      if (start === null) return;
      one.band.setAttribute("x", one.x(Math.min(t, start)));
      one.band.setAttribute("width", Math.abs(one.x(t) - one.x(start)));
    });
    svg.addEventListener("pointerleave", () => this.cursor(this.time));
    svg.addEventListener("pointerdown", (event) => { if (event.pointerType === "mouse") start = timeOf(event); });
    svg.addEventListener("pointerup", (event) => {
      const t = timeOf(event);
      const from = start;
      start = null;
      one.band.setAttribute("width", 0);
      if (from !== null && Math.abs(one.x(t) - one.x(from)) > 8) this.select([Math.min(t, from), Math.max(t, from)]);
      else this.seek(t);
    });
    svg.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.seek((this.time ?? one.from) + (step * (one.to - one.from)) / 50);
    });
  }

  /** Puts the cursor at a time; `passing` where it only follows the pointer. */
  cursor(time, passing = false) {
    if (!passing) this.time = time;
    for (const one of this.drawn) {
      const { plot, legend } = one;
      const shown = time !== null && one.x && time >= one.from && time <= one.to;
      one.line?.setAttribute("visibility", shown ? "visible" : "hidden");
      if (shown) { one.line.setAttribute("x1", one.x(time)); one.line.setAttribute("x2", one.x(time)); }
      const i = shown ? nearest(plot.times, time) : -1;
      legend.replaceChildren(...plot.lines.map((line, k) => {
        const value = i < 0 || line.values[i] === null ? "" : plain(line.values[i], plot.unit);
        return element("span", { class: "key", style: `--key: ${LINE_COLOURS[k % LINE_COLOURS.length]}` }, [line.name, value].filter(Boolean).join(" "));
      }));
    }
  }
}

/** Index of the time nearest to `time`. */
function nearest(times, time) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle;
    else high = middle;
  }
  return high < 0 ? -1 : Math.abs(times[low] - time) <= Math.abs(times[high] - time) ? low : high;
}
