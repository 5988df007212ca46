// Panels around the drawings: score board, tables, boards of scoring places and charts.
import { chart } from "./charts.js";
import { unpack, valueAt } from "./data.js";
import { make, svg } from "./dom.js";
import { MARKS } from "./timeline.js";

/** Score of both sides, clock and period above the drawing; used for replays, live runs and shared pictures. */
export class Score {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.run = run;
    this.home = home;
    this.sides = run.sides.map((one) => ({ ...one, node: make("i", { class: one.side || null, style: one.side ? null : `background:${one.ink}` }) }));
    this.clock = make("b");
    this.period = make("span");
    const [first, ...rest] = this.sides.map(({ node }) => node);
    home.replaceChildren(...first ? [first] : [], make("div", {}, this.clock, this.period), ...rest);
  }

  /** Return the texts to show at a time. @param {number} time */
  at(time) {
    const { run } = this, states = Object.keys(run.meta.lamps).map((name) => [name.split("_")[0], run.lamp(name, time)]);
    const isFree = run.meta.drive && run.meta.drive.free;
    return { clock: isFree ? "free" : run.text("time left", time) ?? "", period: isFree ? "driving" : run.text("period", time) ?? "", sides: this.sides.map(({ label, side }) => ({
      text: run.text(label, time) ?? "", name: side ? "" : label, lit: states.find(([whose, state]) => whose === side && state && state !== "off")?.[1] ?? "" })) };
  }

  draw(time) {
    const now = this.at(time);
    now.sides.forEach(({ text, name, lit }, k) => {
      const { node } = this.sides[k];
      if (node.textContent !== text) node.textContent = text;
      node.dataset.lit = lit;
      node.title = name;
    });
    if (this.clock.textContent !== now.clock) this.clock.textContent = now.clock;
    if (this.period.textContent !== now.period) this.period.textContent = now.period;
    this.home.hidden = !now.clock && now.sides.every(({ text }) => !text);
  }
}

/** Other lines of the score board: labels with texts, and squares for LED strips. */
export class Board {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.home = home;
    this.run = run;
    this.nodes = new Map();
    this.above = new Set(["time left", "period", ...run.sides.map(({ label }) => label)]);
    home.replaceChildren();
  }

  /** @param {number} time @param {number | null} chosen robot whose estimation error is shown */
  draw(time, chosen) {
    for (const item of this.run.meta.board) if (!this.above.has(item.label)) this.put(item.label, valueAt(item, time));
    const pose = chosen === null ? null : this.run.robot(chosen, time);
    this.put("pose estimate off by", pose && pose.belief ? `${Math.hypot(pose.place[0] - pose.belief[0], pose.place[1] - pose.belief[1]).toFixed(2)} m` : null);
  }

  /** Show a line with a label and a text; hide the line if the text is missing. */
  put(label, text) {
    let node = this.nodes.get(label);
    if (text === null && !node) return;
    if (!node) {
      const value = make("b"), item = make("li", {}, make("span", {}, label), value);
      this.home.append(item);
      this.nodes.set(label, node = { item, value, text: null });
    }
    if (node.text === text) return;
    node.text = text;
    node.item.hidden = text === null;
    if (text === null) return;
    if (text.startsWith("led:")) {
      node.value.replaceChildren(...text.slice(4).split(",").map((color) => make("i", color ? { style: `background:#${color}` } : { class: "changing" })));
    } else node.value.textContent = text;
  }
}

/** Draw the events as a list, for readers without a pointer.
 * @param {HTMLElement} home @param {import("./data.js").Run} run @param {(time: number) => void} go */
export function drawEvents(home, run, go) {
  const lines = run.meta.events.map(([time, kind, text]) => make("li", {}, jump(time, `${time.toFixed(2)} s`, go), " ",
    make("span", { class: kind, "aria-hidden": "true" }, MARKS[kind]), ` ${text}`));
  home.replaceChildren(...lines.length ? [make("details", {}, make("summary", {}, `Events (${lines.length})`), make("ol", {}, ...lines))] : []);
}

const jump = (time, text, go) => make("button", { type: "button", class: "to", onclick: () => go(time) }, text);

/** Make a table cell with a text or with a link to a time. */
const cell = (name, content, go, attributes = {}) => make(name, attributes, Array.isArray(content) ? jump(content[0], content[1], go) : content);

/** @param {TableData} table @param {(time: number) => void} go */
export function tableOf({ head, rows }, go) {
  const heads = head.map((text, k) => k ? make("th", { scope: "col" }, text) : make("td", {}, text));
  const lines = rows.map(([first, ...rest]) => make("tr", {}, cell("th", first, go, { scope: "row" }), ...rest.map((one) => cell("td", one, go))));
  return make("div", { class: "wide" }, make("table", {}, make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines)));
}

/** @param {HTMLElement} home @param {import("./data.js").Run} run @param {(time: number) => void} go */
export function drawTables(home, run, go) {
  home.replaceChildren(...run.meta.tables.map((table) => make("details", { open: table.open, class: table.wide ? "several" : null },
    make("summary", {}, table.title), tableOf(table, go))));
}

const BOARD = { width: 360, left: 44, right: 306, row: 30 };

/** Draw the levels of an alliance as rows of scoring places, with a filled mark for each piece and the number of pieces.
 * @param {LevelData[]} levels */
function placeBoard(levels) {
  const widest = levels.reduce((one, other) => other.places.length > one.places.length ? other : one);
  const word = (x, y, content, size, more = {}) => svg("text", { x, y, "font-size": size, fill: "var(--ink)", ...more }, content);
  const bold = { "font-weight": "bold", "text-anchor": "end" }, small = { fill: "var(--muted)" }, side = levels[0].alliance || "neutral", parts = [];
  if (widest.places.length <= 16 && widest.places.every((name) => name.length <= 3)) {
    const wide = (BOARD.right - BOARD.left) / widest.places.length;
    widest.places.forEach((name, k) => parts.push(word(BOARD.left + wide * (k + 0.5), 10, name, 11.5, { ...small, "text-anchor": "middle" })));
  }
  levels.forEach((level, row) => {
    const y = 18 + BOARD.row * (row + 0.5), wide = (BOARD.right - BOARD.left) / Math.max(1, level.count), tall = BOARD.row;
    parts.push(word(BOARD.left - 8, y + 5, level.label, 14, bold));
    for (let k = 0; k < level.count; k++) {
      const x = BOARD.left + wide * k, name = level.places[k], tip = svg("title", {}, name ? `${level.label} ${name}` : level.label);
      const look = (shape, empty, full) => [svg(shape, { ...empty, fill: "none", stroke: "var(--control)" }), svg(shape, { ...full, class: "mark" })];
      const at = { cx: x + 0.5 * wide, cy: y }, box = { x: x + 2, y: y - 0.4 * tall, width: wide - 4, height: 0.8 * tall, rx: 4 };
      const marks = level.single ? look("circle", { ...at, r: 0.3 * Math.min(wide, tall) }, { ...at, r: 0.42 * Math.min(wide, tall), fill: `var(--${side})` }) :
        [...look("rect", box, { ...box, fill: `var(--${side}-fill)`, stroke: `var(--${side})`, "stroke-width": 2 }),
          word(x + 0.5 * wide, y + 5, "0", 14, { class: "n", "text-anchor": "middle" })];
      parts.push(svg("g", { class: "cell", "data-cell": `${level.name}/${k}` }, tip, ...marks));
    }
    parts.push(svg("g", { "data-cell": level.name }, word(BOARD.right + 22, y + 5, "0", 14, { class: "n", ...bold })));
    if (level.single) parts.push(word(BOARD.right + 26, y + 5, `of ${level.count}`, 11.5, small));
  });
  return svg("svg", { viewBox: `0 0 ${BOARD.width} ${22 + BOARD.row * levels.length}` }, ...parts);
}

/** Boards with the numbers of pieces in scoring places. */
export class Places {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    const { levels } = run.meta;
    this.run = run;
    home.replaceChildren(...[...new Set(levels.map(({ alliance }) => alliance))].map((alliance) => make("figure", {},
      make("figcaption", {}, make("strong", {}, alliance ? `Placed for ${alliance}` : "Placed")), placeBoard(levels.filter((level) => level.alliance === alliance)))));
    this.cells = [...home.querySelectorAll("[data-cell]")];
  }

  draw(time) {
    for (const node of this.cells) {
      const count = this.run.count(node.getAttribute("data-cell"), time), number = node.querySelector(".n");
      node.classList.toggle("full", count > 0);
      if (number) number.textContent = String(count);
    }
  }
}

/** Charts of curves over time, with a cursor at the current time; a click goes to the time under the pointer. */
export class Charts {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run @param {(time: number) => void} go */
  constructor(home, run, go) {
    this.run = run;
    this.dirty = new Set();
    const groups = new Map();
    this.charts = run.meta.charts.map((spec) => {
      const node = make("figure"), series = spec.curves.map((curve) => this.curve(curve));
      if (!groups.has(spec.group)) groups.set(spec.group, []);
      groups.get(spec.group).push(node);
      const levels = spec.limit === null ? [] : [{ y: spec.limit, label: `${spec.limit_label} ${spec.limit} ${spec.unit}` }];
      const drawn = chart(node, { title: `${spec.title} [${spec.unit}]`, xLabel: "time [s]", series, levels, fromZero: spec.from_zero,
        xRange: run.meta.live ? null : [run.start, run.end], cursor: run.start, onPick: go });
      return { node, series, drawn };
    });
    home.replaceChildren(...[...groups].map(([name, figures]) => name === "" ? make("div", { class: "charts" }, ...figures) :
      make("details", {}, make("summary", {}, `${name} (${figures.length} charts)`), make("div", { class: "charts" }, ...figures))));
    for (const details of home.querySelectorAll("details")) details.addEventListener("toggle", () => this.draw(this.now ?? run.start));
  }

  /** Decode a curve from scaled integers and time steps in milliseconds. @param {CurveData} curve @returns {SeriesSpec} */
  curve({ label, color, stepped, data, low, scale }) {
    const rows = data ? unpack(this.run.bytes, data) : [], x = [], y = [];
    for (let k = 0, time = this.run.meta.start; k < rows.length; k += 2) {
      x.push(time += rows[k] / 1000);
      y.push(low + (rows[k + 1] + 32000) * scale);
    }
    return { name: label, ...color ? { color } : {}, kind: stepped ? "steps" : "line", x, y };
  }

  draw(time) {
    this.now = time;
    for (const one of this.charts) {
      if (one.node.closest("details:not([open])")) continue;
      if (this.dirty.delete(one)) one.drawn.update(one.series);
      one.drawn.setCursor(time);
    }
  }

  /** Append one value to each curve, in the order of the curves; the next `draw` shows the values. @param {number} time @param {(number | null)[]} values */
  append(time, values) {
    let k = 0;
    for (const one of this.charts) {
      for (const { x, y } of one.series) {
        const value = values[k++];
        if (value === null || value === undefined) continue;
        x.push(time);
        y.push(value);
        this.dirty.add(one);
      }
    }
  }
}
