// Draws charts, heat maps and maps of the field as SVG, as wide as their place, so that their text is legible on a phone.
import { make, svg } from "./dom.js";

const INKS = ["path", "hit", "miss", "ink", "blue", "red"].map((name) => `var(--${name})`);
const DASHES = ["", "6 3", "2 2.5", "8 3 2 3"];  // tell curves apart without their colors
const LETTER = 6.4;  // [px] mean width of a letter of 11.5 px
const GROUND = "var(--soft)";

/** Draw a chart in an element; `setCursor` and `update` of what it returns move and renew it. @param {HTMLElement} home @param {ChartSpec} spec */
export const chart = (home, spec) => new Chart(home, spec);

/** Draw a grid of values as colored cells. @param {HTMLElement} home @param {HeatSpec} spec */
export const heat = (home, spec) => new Heat(home, spec);

/** Draw points with values on the field from above. @param {HTMLElement} home @param {FieldMapSpec} spec */
export const fieldMap = (home, spec) => new FieldMap(home, spec);

/** Round numbers in a range, at most so many. @param {number} low @param {number} high @param {number} most */
export function ticks(low, high, most) {
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = [1, 2, 2.5, 5, 10, 20].map((factor) => factor * power).find((size) => (high - low) / size <= most), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(10)));
  return found;
}

/** Write a value as shortly as a reader needs it. @param {number | null | undefined} value */
export function words(value) {
  if (!isNumber(value)) return "";
  if (Math.abs(value) >= 100 || Math.abs(value - Math.round(value)) < 1e-4) return String(Math.round(value) + 0);
  return Math.abs(value) < 0.1 ? String(Number(value.toPrecision(2))) : value.toFixed(2);
}

/** Keep the first, lowest, highest and last point of each column of pixels; gaps stay. @param {[number, number | null][]} points */
export function thinned(points) {
  const kept = [];
  for (let from = 0, to = 0; from < points.length; from = to) {
    const column = Math.floor(points[from][0]), isGap = points[from][1] === null;
    for (to = from + 1; to < points.length && Math.floor(points[to][0]) === column && (points[to][1] === null) === isGap;) to++;
    if (isGap || to - from < 5) { kept.push(...points.slice(from, isGap ? from + 1 : to)); continue; }
    let low = from, high = from;
    for (let k = from; k < to; k++) {
      if (points[k][1] < points[low][1]) low = k;
      if (points[k][1] > points[high][1]) high = k;
    }
    kept.push(...[...new Set([from, low, high, to - 1])].sort((one, other) => one - other).map((k) => points[k]));
  }
  return kept;
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

/** Lowest and highest of numbers that may be many; null without any. */
function extent(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (isNumber(value)) { low = Math.min(low, value); high = Math.max(high, value); }
  return low <= high ? [low, high] : null;
}

/** Share of the color that stands for high values, as a color. */
const shaded = (share, ink = "var(--path)") => `color-mix(in srgb, ${ink} ${Math.round(8 + 92 * share)}%, ${GROUND})`;

/** Frame of all drawings: title, legend, and an SVG that is drawn again when its place changes its width. */
export class Drawing {
  constructor(home, spec) {
    this.spec = spec;
    this.legend = make("span", { class: "legend" });
    this.readout = make("span", { class: "value" });
    this.drawing = svg("svg", { role: "img", "aria-label": spec.title || "chart" });
    home.classList.add("chart");
    home.replaceChildren(make("figcaption", {}, spec.title ? make("strong", {}, spec.title) : "", this.legend, this.readout), this.drawing);
    this.width = 0;
    new ResizeObserver(() => {
      const width = Math.floor(this.drawing.clientWidth);
      if (width && width !== this.width) { this.width = width; this.paint(); }
    }).observe(home);
    for (const name of ["pointermove", "pointerdown"]) this.drawing.addEventListener(name, (event) => this.point(event, name === "pointerdown"));
    this.drawing.addEventListener("pointerleave", () => this.leave());
  }

  /** Start a picture of a height [px] with nothing in it. */
  begin(height) {
    this.height = height;
    this.drawing.setAttribute("viewBox", `0 0 ${this.width} ${height}`);
    this.drawing.setAttribute("height", height);
    this.drawing.replaceChildren();
  }

  put(name, attributes, ...children) {
    const node = svg(name, attributes, ...children);
    this.drawing.append(node);
    return node;
  }

  text(x, y, content, anchor = "middle", more = {}) {
    return this.put("text", { x, y, "font-size": 11.5, "text-anchor": anchor, fill: "var(--muted)", ...more }, String(content));
  }

  /** Choose the place for axes: `x` and `y` turn values into pixels. */
  axes([fromX, toX], [fromY, toY], { height, left }) {
    const { xLabel } = this.spec, right = this.width - 12, top = 10, bottom = height - (xLabel ? 38 : 22);
    this.box = { left, right, top, bottom };
    this.x = (value) => left + (value - fromX) / (toX - fromX || 1) * (right - left);
    this.y = (value) => bottom - (value - fromY) / (toY - fromY || 1) * (bottom - top);
    this.valueAt = (x) => fromX + (x - left) / (right - left) * (toX - fromX);
  }

  labels(xTicks, yTicks) {
    const { left, right, top, bottom } = this.box, { xLabel, yLabel } = this.spec;
    for (const [at, content] of yTicks) this.text(left - 6, this.y(at) + 4, content, "end");
    let free = -Infinity;  // a label that would touch the one before is left out
    for (const [at, content] of xTicks) {
      const half = LETTER * String(content).length / 2, x = Math.min(Math.max(this.x(at), half + 1), this.width - half - 1);
      if (x - half < free) continue;
      this.text(x, bottom + 16, content);
      free = x + half + 6;
    }
    if (xLabel) this.text((left + right) / 2, this.height - 5, xLabel);
    if (yLabel) this.text(0, 0, yLabel, "middle", { transform: `translate(11 ${(top + bottom) / 2}) rotate(-90)` });
  }

  /** A name as long as there is room for it under the x axis, next to as many others. */
  shortened(name, others) {
    const most = Math.max(3, Math.floor(((this.box.right - this.box.left) / others - 4) / LETTER));
    return name.length > most ? `${name.slice(0, most - 1)}\u2026` : name;
  }

  /** Room [px] that labels of the y axis take. */
  room(labels) { return 12 + LETTER * Math.max(1, ...labels.map((one) => String(one).length)) + (this.spec.yLabel ? 16 : 0); }

  /** A bar of colors from the lowest to the highest value. */
  scale([low, high], unit) {
    const bar = make("i", { class: "shades", style: `background: linear-gradient(90deg, ${shaded(0)}, ${shaded(1)})` });
    this.legend.replaceChildren(words(low), " ", bar, ` ${words(high)}${unit ? ` ${unit}` : ""}`);
  }

  /** Where a pointer is, in pixels of the drawing. */
  place(event) {
    const box = this.drawing.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width * this.width, (event.clientY - box.top) / box.height * this.height];
  }

  point(_event, _isPress) {}
  leave() { this.readout.textContent = ""; }
}

/** Curves, dots, bars and steps on common axes. */
class Chart extends Drawing {
  constructor(home, spec) {
    super(home, spec);
    this.cursor = spec.cursor ?? null;
    this.hover = null;
    this.update(spec.series);
  }

  /** Draw other values. @param {SeriesSpec[]} series */
  update(series) {
    this.series = series.map((one, k) => ({ kind: "line", color: INKS[k % INKS.length], dashes: DASHES[k % DASHES.length], ...one }));
    this.values = this.series.map(() => make("span", { class: "value" }));
    this.legend.replaceChildren(...this.series.map((one, k) => {
      const sample = svg("svg", { viewBox: "0 0 20 6", "aria-hidden": "true" });
      if (one.kind === "dots") sample.append(svg("circle", { cx: 10, cy: 3, r: 3, fill: one.color }));
      else sample.append(svg("path", { d: "M0 3h20", stroke: one.color, "stroke-width": one.kind === "bars" ? 6 : 2.5, "stroke-dasharray": one.kind === "bars" ? "" : one.dashes }));
      return make("span", {}, ...one.name ? [sample, ` ${one.name} `] : [], this.values[k]);
    }));
    if (this.width) this.paint();
  }

  /** Show where time or another x is, and the values there. @param {number | null} x */
  setCursor(x) {
    this.cursor = x;
    if (this.width) this.show();
  }

  paint() {
    const { spec, series } = this, levels = spec.levels ?? [];
    const isBars = series.some(({ kind }) => kind === "bars");
    let [left, right] = spec.xRange ?? extent(series.flatMap(({ x }) => [...x]).concat((spec.marks ?? []).map(({ x }) => x))) ?? [0, 1];
    let [low, high] = extent(series.flatMap(({ y, low: below, high: above }) => [...y, ...below ?? [], ...above ?? []])) ?? [0, 1];
    const isFromZero = spec.fromZero || isBars;
    if (isFromZero) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    const wide = high - low || Math.abs(high) || 1;
    for (const { y } of levels) if (y > low - wide / 2 && y < high + wide / 2) [low, high] = [Math.min(low, y), Math.max(high, y)];
    const span = high - low || Math.abs(high) || 1, gap = spec.xNames || isBars || left === right ? this.step() : 0;
    [left, right] = [left - gap / 2, right + gap / 2];
    [low, high] = spec.yRange ?? [isFromZero && low >= 0 ? low : low - 0.06 * span, high + 0.1 * span];
    const yTicks = ticks(low, high, 5).map((at) => [at, String(at)]);
    this.begin(spec.height ?? Math.round(Math.min(300, Math.max(190, 0.42 * this.width))));
    this.axes([left, right], [low, high], { height: this.height, left: this.room(yTicks.map(([, name]) => name)) });
    const { box } = this, xTicks = spec.xNames ? spec.xNames.map((name, k) => [k, this.shortened(name, spec.xNames.length)]) :
      ticks(left, right, Math.max(2, Math.floor((box.right - box.left) / 56))).map((at) => [at, String(at)]);
    for (const [at] of yTicks) this.put("path", { d: `M${box.left} ${this.y(at)}H${box.right}`, stroke: at === 0 ? "var(--control)" : "var(--grid)" });
    this.labels(xTicks, yTicks);
    for (const level of levels) {
      if (level.y < low || level.y > high) continue;
      this.put("path", { d: `M${box.left} ${this.y(level.y)}H${box.right}`, stroke: "var(--ink)", "stroke-dasharray": "4 3" });
      this.text(box.right, this.y(level.y) - 4, level.label ?? "", "end");
    }
    for (const mark of spec.marks ?? []) {
      const x = this.x(mark.x), isLate = x > (box.left + box.right) / 2;
      this.put("path", { d: `M${x} ${box.top}V${box.bottom}`, stroke: "var(--ink)", "stroke-dasharray": "2 3" });
      this.text(x + (isLate ? -4 : 4), box.top + 10, mark.label ?? "", isLate ? "end" : "start");
    }
    const bars = series.filter(({ kind }) => kind === "bars");
    series.forEach((one) => this.draw(one, bars.indexOf(one), bars.length));
    this.line = this.put("path", { class: "cursor", stroke: "var(--ink)" });
    this.show();
  }

  /** Least distance between two x of a series, for the width of bars and of names. */
  step() {
    let least = Infinity;
    for (const { x } of this.series) for (let k = 1; k < x.length; k++) if (x[k] > x[k - 1]) least = Math.min(least, x[k] - x[k - 1]);
    return Number.isFinite(least) ? least : 1;
  }

  draw(one, number, bars) {
    const { color, kind, low, high } = one, { box } = this;
    const points = Array.from(one.x, (x, k) => [this.x(x), isNumber(one.y[k]) ? this.y(one.y[k]) : null]);
    const f = (value) => value.toFixed(1);
    if (kind === "bars") {
      const slot = 0.8 * this.step() * (this.x(1) - this.x(0)) / bars, zero = Math.min(box.bottom, this.y(0));
      points.forEach((point) => { point[0] += (number - (bars - 1) / 2) * slot; });
      for (const [x, y] of points) {
        if (y !== null) this.put("rect", { x: f(x - 0.45 * slot), y: f(Math.min(y, zero)), width: f(Math.max(0.5, 0.9 * slot)), height: f(Math.max(0.5, Math.abs(y - zero))), fill: color });
      }
    }
    if (low && high) {
      const ends = points.map(([x], k) => isNumber(low[k]) && isNumber(high[k]) ? [x, this.y(low[k]), this.y(high[k])] : null);
      if (kind === "line" || kind === "steps") {
        for (const part of runs(ends)) {
          const d = [...part.map(([x, , y]) => [x, y]), ...part.reverse().map(([x, y]) => [x, y])];
          this.put("path", { d: `M${d.map((at) => at.map(f).join(" ")).join("L")}Z`, fill: color, "fill-opacity": 0.18 });
        }
      } else {
        const d = ends.map((end) => end && `M${f(end[0] - 4)} ${f(end[1])}h8m-4 0V${f(end[2])}m-4 0h8`).filter(Boolean).join("");
        this.put("path", { d, fill: "none", stroke: kind === "bars" ? "var(--ink)" : color, "stroke-width": 1.3 });
      }
    }
    if (kind === "dots") for (const [x, y] of points) if (y !== null) this.put("circle", { cx: f(x), cy: f(y), r: points.length > 200 ? 2 : 3.5, fill: color });
    if (kind !== "line" && kind !== "steps") return;
    let d = "", last = null;
    for (const [x, y] of thinned(points)) {
      if (y !== null) d += last === null ? `M${f(x)} ${f(y)}h.01` : kind === "steps" && y !== last ? `H${f(x)}V${f(y)}` : `L${f(x)} ${f(y)}`;
      last = y;
    }
    this.put("path", { d, fill: "none", stroke: color, "stroke-width": 1.8, "stroke-dasharray": one.dashes, "stroke-linejoin": "round" });
  }

  point(event, isPress) {
    if (!this.x) return;
    const x = this.valueAt(this.place(event)[0]);
    let best = null;
    for (const one of this.series) for (const at of one.x) if (best === null || Math.abs(at - x) < Math.abs(best - x)) best = at;
    this.hover = best;
    this.show();
    if (isPress && this.spec.onPick) this.spec.onPick(Math.min(this.valueAt(this.box.right), Math.max(this.valueAt(this.box.left), x)));
  }

  leave() {
    this.hover = null;
    this.show();
  }

  /** Draw the cursor and write the values there. */
  show() {
    const at = this.hover ?? this.cursor, { box, spec } = this, isSeen = at !== null && this.line;
    if (this.line) this.line.setAttribute("d", isSeen ? `M${this.x(at).toFixed(1)} ${box.top}V${box.bottom}` : "");
    this.series.forEach((one, k) => {
      let row = -1;
      if (at !== null) for (let low = 0, high = one.x.length - 1; low <= high;) {
        const middle = (low + high) >> 1;
        if (one.x[middle] <= at + 1e-6) { row = middle; low = middle + 1; } else high = middle - 1;
      }
      const value = row < 0 ? "" : words(one.y[row]);
      this.values[k].textContent = value && one.low && isNumber(one.low[row]) ? `${value} (${words(one.low[row])} to ${words(one.high[row])})` : value;
    });
    this.readout.textContent = this.hover === null ? "" : `at ${spec.xNames ? spec.xNames[this.hover] ?? "" : words(this.hover)}`;
  }
}

/** Parts of a list between its gaps. */
function runs(list) {
  const found = [[]];
  for (const one of list) if (one) found.at(-1).push(one); else found.push([]);
  return found.filter((part) => part.length > 1);
}

/** Cells of a grid, colored by value; equal neighbors of a row are one rectangle. */
class Heat extends Drawing {
  paint() {
    const { spec } = this, { values, marks = [] } = spec, xs = edges(spec.x, spec.xNames), ys = edges(spec.y, spec.yNames);
    const [low, high] = spec.range ?? extent(values.flat()) ?? [0, 1];
    const named = (names, at, most, isAcross) => names ? names.map((name, k) => [k, isAcross ? this.shortened(name, names.length) : name]) : ticks(at[0], at.at(-1), most).map((value) => [value, String(value)]);
    const yTicks = named(spec.yNames, ys, 6);
    this.begin(spec.height ?? Math.round(Math.min(340, Math.max(200, 0.55 * this.width))));
    this.axes([xs[0], xs.at(-1)], [ys[0], ys.at(-1)], { height: this.height, left: this.room(yTicks.map(([, name]) => name)) });
    const { box } = this, cell = (box.right - box.left) / (xs.length - 1), tall = (box.bottom - box.top) / (ys.length - 1);
    this.put("rect", { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top, fill: "var(--paper)" });
    const shown = [];
    values.forEach((row, r) => {
      const [y, height] = [this.y(ys[r + 1]), this.y(ys[r]) - this.y(ys[r + 1])];
      for (let from = 0, to = 0; from < row.length; from = to) {
        for (to = from + 1; to < row.length && row[to] === row[from];) to++;
        if (!isNumber(row[from])) continue;
        const share = high > low ? Math.min(1, Math.max(0, (row[from] - low) / (high - low))) : 1, x = this.x(xs[from]);
        this.put("rect", { x: x.toFixed(2), y: y.toFixed(2), width: (this.x(xs[to]) - x).toFixed(2), height: height.toFixed(2), "shape-rendering": "crispEdges", style: `fill: ${shaded(share)}` });
        for (let k = from; k < to; k++) if (cell > 30 && tall > 15) shown.push([(this.x(xs[k]) + this.x(xs[k + 1])) / 2, y + height / 2 + 4, words(row[k])]);
      }
    });
    for (const [x, y, content] of shown) this.text(x, y, content, "middle", { fill: "var(--ink)" });
    for (const mark of marks) {
      const x = this.x(mark.x), y = this.y(mark.y);
      for (const [stroke, width] of [["var(--paper)", 5], ["var(--ink)", 2]]) {
        this.put("path", { d: `M${x - 7} ${y}h14M${x} ${y - 7}v14`, stroke, "stroke-width": width });
      }
      if (mark.label) this.text(x + 8, y - 6, mark.label, "start", { fill: "var(--ink)" });
    }
    const most = Math.max(2, Math.floor((box.right - box.left) / 56));
    this.labels(named(spec.xNames, xs, most, true), yTicks);
    if (spec.scale !== false) this.scale([low, high], spec.unit);
    this.cells = { xs, ys };
  }

  point(event) {
    if (!this.cells) return;
    const { spec, cells } = this, [px, py] = this.place(event);
    const column = cells.xs.findIndex((_, k) => k + 1 < cells.xs.length && px >= this.x(cells.xs[k]) && px < this.x(cells.xs[k + 1]));
    const row = cells.ys.findIndex((_, k) => k + 1 < cells.ys.length && py <= this.y(cells.ys[k]) && py > this.y(cells.ys[k + 1]));
    const value = column < 0 || row < 0 ? null : spec.values[row][column];
    const at = (names, list, k) => names ? names[k] : words(list[k]);
    this.readout.textContent = isNumber(value) ? `${words(value)}${spec.unit ? ` ${spec.unit}` : ""} at ${at(spec.xNames, spec.x, column)}, ${at(spec.yNames, spec.y, row)}` : "";
  }
}

/** Edges of cells whose middles are given, or named. @param {number[]} middles @param {string[] | null} [names] */
export function edges(middles, names) {
  const at = names ? names.map((_, k) => k) : middles;
  if (at.length < 2) return [at[0] - 0.5, at[0] + 0.5];
  const between = at.slice(1).map((value, k) => (value + at[k]) / 2);
  return [2 * at[0] - between[0], ...between, 2 * at.at(-1) - between.at(-1)];
}

/** The field from above, and points on it that are colored by their value or have a color. */
class FieldMap extends Drawing {
  paint() {
    const { spec } = this, [length, width] = spec.size, edge = 0.25;
    const scale = this.width / (length + 2 * edge), at = ([x, y]) => [(x + edge) * scale, (width + edge - y) * scale];
    this.begin(Math.round((width + 2 * edge) * scale));
    const [x, y] = at([0, width]);
    this.put("rect", { x, y, width: length * scale, height: width * scale, fill: "var(--carpet)", stroke: "var(--control)" });
    for (const [color, corners] of spec.outlines ?? []) {
      this.put("path", { d: `M${corners.map((one) => at(one).map((value) => value.toFixed(1)).join(" ")).join("L")}Z`, fill: color, "fill-opacity": 0.55, stroke: color });
    }
    const range = spec.range ?? extent(spec.points.map(({ value }) => value));
    const size = spec.pointSize ? Math.max(1.5, spec.pointSize * scale) : spec.points.length > 300 ? 2 : Math.min(7, Math.max(3.5, 0.12 * scale));
    this.dots = spec.points.map((point) => {
      const [cx, cy] = at([point.x, point.y]);
      const share = range && isNumber(point.value) ? (point.value - range[0]) / (range[1] - range[0] || 1) : 1;
      this.put("circle", { cx: cx.toFixed(1), cy: cy.toFixed(1), r: size, style: `fill: ${point.color ?? shaded(share)}`, stroke: "var(--control)", "stroke-width": size > 2 ? 0.8 : 0 });
      return [cx, cy, point];
    });
    if (range && spec.points.some(({ color }) => !color)) this.scale(range, spec.unit);
  }

  point(event) {
    if (!this.dots) return;
    const [px, py] = this.place(event), far = ([x, y]) => Math.hypot(x - px, y - py);
    const near = this.dots.reduce((best, one) => best === null || far(one) < far(best) ? one : best, null);
    if (!near || far(near) > 20) { this.leave(); return; }
    const { label, value, x, y } = near[2], unit = this.spec.unit ? ` ${this.spec.unit}` : "";
    this.readout.textContent = [label, isNumber(value) ? `${words(value)}${unit}` : "", `at (${words(x)}, ${words(y)}) m`].filter(Boolean).join(" ");
  }
}
