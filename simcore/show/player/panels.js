// Everything around the drawings: score board, marks over the time, tables, boards of places and charts.
import { ticks } from "./charts.js";
import { rowAt, unpack } from "./data.js";
import { make, svg } from "./dom.js";

const MARKS = { mode: "\u25b6", put: "\u21e9", hit: "\u25cf", miss: "\u2715", pass: "\u2192", flying: "\u25cb", score: "+", slip: "\u2248",
  bump: "\u25b2", "brown-out": "\u25bc", foul: "\u25c6", placed: "\u25a3" };
const ROWS = [["mode", "put"], ["hit", "miss", "pass", "flying"], ["placed", "score", "foul"], ["slip", "bump", "brown-out"]];
const PLOT = { total: 360, bottom: 178, left: 44, width: 306, top: 8, height: 132 };

/** Score board: labels with a text each, and squares for strips of lights. */
export class Board {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.home = home;
    this.run = run;
    this.nodes = new Map();
    home.replaceChildren();
  }

  draw(time) {
    for (const item of this.run.meta.board) {
      if (item.times.length) this.put(item.label, item.values[rowAt(item.times, time)]);
    }
    const apart = this.run.meta.robots.map((_, k) => this.run.robot(k, time)).filter((pose) => pose && pose.belief)
      .map(({ place, belief }) => Math.hypot(place[0] - belief[0], place[1] - belief[1]).toFixed(2));
    if (apart.length) this.put("pose estimate off by", `${apart.join(", ")} m`);
  }

  put(label, text) {
    let node = this.nodes.get(label);
    if (!node) {
      const value = make("b");
      const kind = ["blue", "red", "period", "time left"].includes(label) ? label.replace(" ", "-") : "other";
      this.home.append(make("li", { class: kind }, make("span", {}, label), value));
      this.nodes.set(label, node = { value, text: null });
    }
    if (node.text === text) return;
    node.text = text;
    if (text.startsWith("led:")) {
      node.value.replaceChildren(...text.slice(4).split(",").map((color) => make("i", color ? { style: `background:#${color}` } : { class: "changing" })));
    } else node.value.textContent = text;
  }
}

/** Rows of marks over the time, and the same as a list for readers without a pointer.
 * @param {HTMLElement} home @param {HTMLElement} list @param {import("./data.js").Run} run @param {(time: number) => void} go */
export function drawEvents(home, list, run, go) {
  const { start, end } = run, rows = [];
  for (const kinds of ROWS) {
    const mine = run.meta.events.filter(([, kind]) => kinds.includes(kind));
    if (!mine.length) continue;
    const marks = mine.map(([time, kind, text]) => make("button", {
      type: "button", tabindex: "-1", class: kind, title: `${time.toFixed(2)} s: ${text}`, style: `left:${100 * (time - start) / (end - start || 1)}%`,
      onclick: () => go(time) }, MARKS[kind]));
    const name = kinds.filter((kind) => mine.some((event) => event[1] === kind)).join(", ");
    rows.push(make("div", { class: "row" }, make("span", {}, name), make("div", {}, ...marks)));
  }
  home.replaceChildren(...rows);
  const lines = run.meta.events.map(([time, kind, text]) => make("li", {}, jump(time, `${time.toFixed(2)} s`, go), " ",
    make("span", { class: kind, "aria-hidden": "true" }, MARKS[kind]), ` ${text}`));
  list.replaceChildren(...lines.length ? [make("details", {}, make("summary", {}, `Events (${lines.length})`), make("ol", {}, ...lines))] : []);
}

const jump = (time, text, go) => make("button", { type: "button", class: "to", onclick: () => go(time) }, text);

/** A cell is a text, or a time and a text that goes there. */
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

/** Counts in places of the field and on their boards. */
export class Places {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    home.innerHTML = run.meta.places.map((board) => `<figure>${board}</figure>`).join("");  // drawn and escaped in Python
    this.cells = [...document.querySelectorAll("[data-cell]")].map((node) => ({ node, steps: run.meta.cells[node.getAttribute("data-cell")] ??= { times: [], values: [] } }));
  }

  draw(time) {
    for (const { node, steps } of this.cells) {
      const count = steps.times.length ? steps.values[rowAt(steps.times, time)] : 0, number = node.querySelector(".n");
      node.classList.toggle("full", count > 0);
      if (number) number.textContent = String(count);
    }
  }
}

/** Curves over time, a cursor where the run is, and the values there; a click goes to its time. */
export class Charts {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run @param {(time: number) => void} go */
  constructor(home, run, go) {
    this.run = run;
    this.charts = run.meta.charts.map((chart) => ({ ...chart, curves: chart.curves.map((curve) => this.curve(curve)) }));
    const groups = new Map();
    for (const chart of this.charts) {
      if (!groups.has(chart.group)) groups.set(chart.group, []);
      groups.get(chart.group).push(this.figure(chart, go));
    }
    home.replaceChildren(...[...groups].map(([name, figures]) => name === "" ? make("div", { class: "charts" }, ...figures) :
      make("details", {}, make("summary", {}, `${name} (${figures.length} charts)`), make("div", { class: "charts" }, ...figures))));
    for (const details of home.querySelectorAll("details")) details.addEventListener("toggle", () => this.draw(this.now ?? run.start));
  }

  /** Values are whole numbers times a scale, at times in milliseconds. @param {CurveData} curve */
  curve(curve) {
    if (!curve.data) return { ...curve, times: [], values: [] };
    const rows = unpack(this.run.bytes, curve.data), times = [], values = [];
    for (let k = 0, time = this.run.meta.start; k < rows.length; k += 2) {
      times.push(time += rows[k] / 1000);
      values.push(curve.low + (rows[k + 1] + 32000) * curve.scale);
    }
    return { ...curve, times, values };
  }

  /** @param {ChartData} chart @param {(time: number) => void} go */
  figure(chart, go) {
    chart.drawing = svg("svg", { viewBox: `0 0 ${PLOT.total} ${PLOT.bottom}`, role: "img", "aria-label": `${chart.title} over time` });
    chart.labels = chart.curves.map((curve) => {
      const value = make("span", { class: "value" }), sample = svg("svg", { viewBox: "0 0 20 6" });
      sample.append(svg("path", { d: "M0 3h20", stroke: curve.color, "stroke-width": 2.5, "stroke-dasharray": curve.dashes }));
      return [make("span", {}, sample, ` ${curve.label} `, value), value];
    });
    chart.drawing.addEventListener("click", (event) => {
      const box = chart.drawing.getBoundingClientRect(), x = (event.clientX - box.left) / box.width * PLOT.total;
      go(this.run.start + Math.min(1, Math.max(0, (x - PLOT.left) / PLOT.width)) * (this.run.end - this.run.start));
    });
    chart.node = make("figure", { class: "chart" }, make("figcaption", {}, make("strong", {}, `${chart.title} [${chart.unit}]`),
      ...chart.labels.map(([label]) => label)), chart.drawing);
    chart.isDrawn = false;
    return chart.node;
  }

  /** Axes and curves, once; of a live run again as it grows. @param {ChartData} chart */
  paint(chart) {
    const { start, end } = this.run, all = chart.curves.flatMap((curve) => curve.values).filter(Number.isFinite);
    let low = Math.min(...all, chart.from_zero ? 0 : Infinity), high = Math.max(...all, chart.from_zero ? 0 : -Infinity);
    if (!Number.isFinite(low)) [low, high] = [0, 1];
    const limit = chart.limit;
    if (limit !== null && low - 0.5 * limit <= limit && limit <= high + 0.5 * limit) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
    const span = high - low || 1;
    [low, high] = [low < 0 || !chart.from_zero ? low - 0.06 * span : low, low + span + 0.1 * span];
    const x = (time) => PLOT.left + (time - start) / (end - start || 1) * PLOT.width, y = (value) => PLOT.top + (high - value) / (high - low) * PLOT.height;
    const parts = [], words = (at, up, text, anchor, more = {}) => {
      const node = svg("text", { x: at, y: up, "font-size": 11.5, "text-anchor": anchor, fill: "var(--muted)", ...more });
      node.textContent = text;
      parts.push(node);
    };
    const right = PLOT.left + PLOT.width, bottom = PLOT.top + PLOT.height;
    for (const level of ticks(low, high, 5)) {
      parts.push(svg("path", { d: `M${PLOT.left} ${y(level)}H${right}`, stroke: "var(--grid)" }));
      words(PLOT.left - 5, y(level) + 4, String(level), "end");
    }
    for (const time of ticks(start, end || 1, 7)) words(x(time), bottom + 16, String(time), "middle");
    words(right, PLOT.bottom - 5, "time [s]", "end");
    words(0, 0, `[${chart.unit}]`, "middle", { transform: `translate(10 ${PLOT.top + PLOT.height / 2}) rotate(-90)` });
    if (limit !== null && low <= limit && limit <= high) {
      parts.push(svg("path", { d: `M${PLOT.left} ${y(limit)}H${right}`, stroke: "var(--ink)", "stroke-dasharray": "4 3" }));
      words(right, y(limit) - 4, `${chart.limit_label} ${limit} ${chart.unit}`, "end");
    }
    for (const curve of chart.curves) {
      let d = "", last = null;
      curve.values.forEach((value, k) => {
        if (!Number.isFinite(value)) return;
        if (curve.stepped && last !== null && value !== last) d += `L${x(curve.times[k]).toFixed(1)} ${y(last).toFixed(1)}`;
        d += `${last === null ? "M" : "L"}${x(curve.times[k]).toFixed(1)} ${y(value).toFixed(1)}`;
        last = value;
      });
      parts.push(svg("path", { d, fill: "none", stroke: curve.color, "stroke-width": 1.6, "stroke-dasharray": curve.dashes }));
    }
    chart.cursor = svg("path", { class: "cursor", stroke: "var(--ink)" });
    chart.drawing.replaceChildren(...parts, chart.cursor);
    chart.isDrawn = true;
  }

  draw(time) {
    this.now = time;
    const { start, end } = this.run;
    for (const chart of this.charts) {
      if (chart.node.closest("details:not([open])")) continue;
      if (!chart.isDrawn) this.paint(chart);
      chart.cursor.setAttribute("d", `M${(PLOT.left + (time - start) / (end - start || 1) * PLOT.width).toFixed(1)} ${PLOT.top}v${PLOT.height}`);
      chart.curves.forEach((curve, k) => {
        const value = curve.values[rowAt(curve.times, time)];
        chart.labels[k][1].textContent = value === undefined || !Number.isFinite(value) ? "" :
          Math.abs(value) >= 100 || Math.abs(value - Math.round(value)) < 1e-4 ? String(Math.round(value) + 0) : value.toFixed(2);
      });
    }
  }

  /** Live: a value for each curve, in order. */
  append(time, values) {
    let k = 0;
    for (const chart of this.charts) {
      chart.isDrawn = false;
      for (const curve of chart.curves) {
        const value = values[k++];
        if (value === null || value === undefined) continue;
        curve.times.push(time);
        curve.values.push(value);
      }
    }
  }
}
