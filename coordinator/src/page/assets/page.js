// The page: made of one message, again and again while a run is running.

const dom = (id) => document.getElementById(id);

class Page {
  constructor(run) {
    this.live = dom("run").dataset.live ? new Live(this) : null;
    this.root = dom("page");
    this.plots = new Plots((time) => this.player?.seek(time));
    this.side = element("div", { class: "side" });
    this.first = element("div", { class: "first" }, this.side);
    this.below = element("div");
    this.tables = element("div");
    this.root.append(...(this.live ? [this.live.element] : []), this.first, this.below, this.plots.element, this.tables);
    this.take(run);
    if (!this.live && this.player) {
      readEmbedded(run, (k, frame) => {
        this.player.take(k, frame);
        // A failed run is shown as it ended.
        if (k === run.frames.length - 1) this.allRead();
      }).catch((problem) => { this.player.readings.textContent = `The frames cannot be read: ${problem.message}`; });
    }
  }

  allRead() {
    if (!this.run.culprit) return;
    this.player.show(this.run.frames.length - 1, true);
    this.player.picked = null;
  }

  take(run) {
    this.run = run;
    if (run.scene && !this.player) {
      this.player = new Player(run, (time) => this.plots.cursor(time));
      this.first.prepend(this.player.element);
    } else if (run.scene) this.player.run = run;
    const verdict = dom("verdict");
    if (verdict) {
      verdict.textContent = run.verdict;
      const kind = run.verdict.includes("reservations") ? "reserved" : run.verdict;
      verdict.className = `verdict ${kind}`;
      dom("reason").className = `reason ${kind}`;
      dom("sentence").textContent = run.sentence;
      dom("reason").textContent = run.reason;
    }
    this.side.replaceChildren(...[this.failure(), this.reservations(), this.figures()].filter(Boolean));
    this.below.replaceChildren(...[this.quality(), this.budgets()].filter(Boolean));
    this.plots.take(run.plots);
    this.tables.replaceChildren(...this.facts());
  }

  failure() {
    const { culprit } = this.run;
    if (!culprit) return null;
    const place = culprit.position.map((x) => fixed(x, 4)).join(", ");
    const approach = element("button", { type: "button", onclick: () => { this.player?.show(this.run.frames.length - 1, true); this.player?.approach(culprit.position); } }, "show it close up");
    return element("section", { class: "failure", id: "culprit" }, element("h2", {}, "What ended the run"),
      element("p", {}, `Particle ${culprit.id} at (${place}) m. `, this.player ? approach : null),
      element("p", {}, element("a", { href: "divergence.csv" }, "divergence.csv"), " lists it and its neighbours."));
  }

  reservations() {
    const { reservations, warnings, quality } = this.run;
    if (!reservations.length && !warnings.length) return null;
    const judged = quality.filter((figure) => figure.verdict === "reservation").map((figure) => `${figure.name} ${figure.value}, should be ${figure.threshold}: ${figure.meaning}. What to do: ${figure.advice}.`);
    const list = (texts) => element("ul", {}, texts.map((text) => element("li", {}, text)));
    return element("section", { class: "warnings", id: "warnings" },
      reservations.length ? [element("h2", {}, "Reservations"), list(judged.length ? judged : reservations)] : null,
      warnings.length ? element("details", { open: warnings.length < 2 }, element("summary", {}, element("h2", {}, `Warnings (${warnings.length})`)), list(warnings)) : null);
  }

  figures() {
    const { figures, first_figures: first } = this.run;
    if (!figures.length) return null;
    const when = (text, time, figure, where) => {
      if (!text) return null;
      const go = () => { this.player?.seek(time); if (where && figure.position) this.player?.approach(figure.position, Math.max(2, this.player.camera.factor)); };
      return this.player ? element("button", { type: "button", class: "time", title: "show the particles then", onclick: go }, text) : element("span", { class: "time" }, text);
    };
    const row = (figure) => element("tr", {}, element("th", { scope: "row" }, figure.name, figure.place ? element("small", {}, figure.place) : null),
      element("td", {}, figure.largest, when(figure.largest_at, figure.largest_time, figure, true)),
      element("td", {}, figure.smallest, when(figure.smallest_at, figure.smallest_time, figure, false)), element("td", { class: "last-value" }, figure.last));
    const table = (rows) => element("table", { class: "figures-table" },
      element("thead", {}, element("tr", {}, ["quantity", "largest", "smallest", "last"].map((name) => element("th", { scope: "col", class: name === "last" ? "last-value" : null }, name)))), element("tbody", {}, rows.map(row)));
    const rest = figures.slice(first);
    const isOpen = dom("all-figures")?.open;
    return element("section", { id: "figures" }, element("h2", {}, "Key figures"), table(figures.slice(0, first)),
      rest.length ? element("details", { id: "all-figures", open: isOpen }, element("summary", {}, `${rest.length} more`), table(rest)) : null);
  }

  quality() {
    const { quality } = this.run;
    if (!quality.length) return this.live ? element("section", { id: "quality" }, element("h2", {}, "Quality"), element("p", { class: "note" }, "Judged when the run has ended.")) : null;
    const words = { good: "good", reservation: "reservation", "not-judged": "not judged" };
    return element("section", { id: "quality" }, element("h2", {}, "Quality"),
      element("p", { class: "note" }, "What the run says of its own answer, by thresholds that are the same for all runs. Whether its spacing is fine enough no single run can tell: tidelock converge does."),
      element("div", { class: "cards" }, quality.map((figure) => element("div", { class: `card ${figure.verdict}` },
        element("p", { class: "name" }, figure.name, element("span", { class: "judged" }, words[figure.verdict] ?? figure.verdict)),
        element("p", { class: "value" }, figure.value || "–", element("small", {}, ` ${figure.threshold}`)),
        element("p", { class: "note" }, `${figure.meaning}${figure.verdict === "reservation" ? `. What to do: ${figure.advice}` : ""}`)))));
  }

  budgets() {
    const { budgets } = this.run;
    if (!budgets.length) return null;
    return element("section", { id: "budget" }, element("h2", {}, "Energy budget"),
      element("p", { class: "note" }, "Where the energy went by the last row of the ledger: change of the stores = works − losses + residual."),
      element("div", { class: "budgets" }, budgets.map((budget) => {
        const most = Math.max(...budget.accounts.map((account) => Math.abs(account.value)));
        return element("table", { class: "budget" }, element("caption", {}, budget.side), element("tbody", {}, budget.accounts.map((account) => {
          const share = (50 * Math.abs(account.value)) / most;
          return element("tr", { class: account.kind }, element("th", { scope: "row" }, account.name, account.kind === account.name ? null : element("small", {}, ` ${account.kind}`)),
            element("td", { class: "bar-cell" }, element("span", { class: "beam", style: `${account.value < 0 ? "right" : "left"}: 50%; width: ${Math.max(share, 0.4)}%` })), element("td", {}, account.text));
        })));
      })));
  }

  facts() {
    const { tables, links, next } = this.run;
    const rows = (list) => element("table", {}, element("tbody", {}, list.map(([name, value]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", {}, value)))));
    const sections = tables.filter((table) => table.rows.length).map((table) =>
      element("section", { id: table.id }, element("details", { open: this.open?.[table.id] }, element("summary", {}, element("h2", {}, table.headline)), rows(table.rows))));
    const files = links.length ? element("section", { id: "files" }, element("h2", {}, "Files and next steps"),
      element("ul", {}, links.map((link) => element("li", {}, this.live ? link.file : element("a", { href: link.file }, link.file), `: ${link.meaning}`))),
      next.length ? element("ul", {}, next.map(([what, command]) => element("li", {}, `${what}: `, element("code", {}, command)))) : null) : null;
    return [files, ...sections].filter(Boolean);
  }
}

/** Memory for frames of a running run [bytes]. */
const MOST_BYTES = 256e6;

/** Rest between two updates over what the last one took. */
const IDLE = 100;

/** When what was changed has been drawn. */
const painted = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

/** Follows a run: its state by server-sent events, its figures and frames by request, as fast as this browser takes them. */
class Live {
  constructor(page) {
    this.page = page;
    this.token = new URLSearchParams(location.hash.slice(1)).get("token");
    this.meter = element("progress", { max: 1, value: 0, "aria-label": "part of the simulated time that is done" });
    this.words = element("p", { class: "doing", role: "status" });
    this.facts = element("dl", { class: "live-facts", role: "group", tabindex: "0", "aria-label": "state of the run" });
    const order = (what, label) => element("button", { type: "button", onclick: () => this.order(what, label), disabled: !this.token }, label);
    this.answer = element("span", { role: "status", class: "answer" });
    this.buttons = element("div", { class: "orders" }, order("checkpoint", "take a checkpoint"), order("stop", "stop the run"), this.answer);
    if (!this.token) this.answer.textContent = "read-only: open the whole link that the run printed to use these";
    this.element = element("section", { id: "live", "aria-label": "state of the run" }, this.words, this.meter, this.facts, this.buttons);
    this.version = -1;
    this.listen();
  }

  listen() {
    const events = new EventSource("api/events");
    events.addEventListener("status", (event) => this.status(JSON.parse(event.data)));
    events.onerror = () => { if (!this.ended) this.words.textContent = "No answer from the run: it has ended, or the connection is lost. What was read stays."; };
    this.events = events;
  }

  status({ status, version, frames }) {
    this.words.textContent = status.doing;
    this.meter.value = status.share;
    const rows = [["time", `${seconds(status.time)} of ${seconds(status.end_time)}, ${(100 * status.share).toFixed(0)} %`], ["step", String(status.steps)], ["elapsed", status.elapsed], ["left", status.left], ...status.figures];
    this.facts.replaceChildren(...rows.filter(([, value]) => value).map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))));
    this.tellCheckpoint(rows.find(([name]) => name === "last checkpoint")?.[1]);
    this.frames = frames;
    this.wanted = version;
    if (status.ended) {
      this.ended = true;
      this.wake?.();
      this.buttons.hidden = true;
      this.events.close();
    }
    this.update();
  }

  /** One request at a time: what comes meanwhile is taken next. */
  async update() {
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.version < this.wanted) {
        const version = this.wanted;
        const begun = performance.now();
        const run = await (await fetch("api/run")).json();
        this.version = version;
        this.page.take(run);
        await this.readFrames(run);
        if (!document.hidden) await painted();
        // The run may need the cores that draw this page. At the start much is new: the rest is no longer than the page is
        // open. The end of the run is not slept through.
        const now = performance.now();
        await this.rest(Math.max(500, Math.min(now, IDLE * (now - begun))));
      }
    } catch (problem) {
      console.debug(problem);
    } finally {
      this.busy = false;
    }
  }

  /** Waits so many milliseconds, or until the run has ended. */
  rest(most) {
    if (this.ended) return null;
    return new Promise((resolve) => {
      this.wake = resolve;
      setTimeout(resolve, most);
    });
  }

  async readFrames(run) {
    const { player } = this.page;
    if (!player) return;
    for (let k = player.frames.length; k < run.frames.length; k++) {
      const isLast = k === run.frames.length - 1;
      // No more than fits: of a long run every second, third … frame, and the last. A run that has ended serves no longer
      // than a moment: of what is unread then, the last.
      const size = player.frames[0] ? 2 * player.frames[0].count * player.frames[0].columns.length : 0;
      const stride = Math.max(1, Math.ceil((size * run.frames.length) / MOST_BYTES));
      if (!isLast && (this.ended || k % stride !== 0)) { player.frames.length = k + 1; continue; }
      const answer = await fetch(`api/frames/${k}`);
      if (!answer.ok) break;
      const facts = await answer.json();
      player.widen(facts.scales);
      player.take(k, decoded(await inflated(facts.data), facts, facts.columns));
    }
    // Of those that came together the newest is drawn, unless somebody looks at another one meanwhile.
    if ((player.follows ?? true) && !player.playing) player.show(player.frames.length - 1);
  }

  /** Says when the checkpoint that was asked for is there. */
  tellCheckpoint(newest) {
    this.checkpoint = newest ?? "";
    if (this.before === undefined || this.before === this.checkpoint) return;
    this.answer.textContent = `checkpoint taken: ${newest}`;
    this.before = undefined;
  }

  async order(what, label) {
    this.answer.textContent = `${label} …`;
    if (what === "checkpoint") this.before = this.checkpoint;
    const answer = await fetch(`api/${what}`, { method: "POST", headers: { authorization: `Bearer ${this.token}` } });
    this.answer.textContent = answer.ok ? `${label}: at the next step boundary` : `${label}: refused (${answer.status})`;
  }
}

/** Scales of a running run only ever grow. */
Player.prototype.widen = function (scales) {
  let grown = false;
  for (const scale of scales) {
    const known = this.scales(scale.matter).find((one) => one.field === scale.field);
    if (!known) continue;
    const [lower, upper] = [Math.min(known.lower, scale.lower), Math.max(known.upper, scale.upper)];
    const signed = known.signed || scale.signed;
    const most = Math.max(-lower, upper);
    const [a, b] = signed ? [-most, most] : [lower, upper];
    if (a !== known.lower || b !== known.upper) { Object.assign(known, { lower: a, upper: b, signed }); grown = true; }
  }
  if (grown) this.recolour();
};

window.page = new Page(JSON.parse(dom("run").textContent));
