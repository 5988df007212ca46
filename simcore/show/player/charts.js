// Charts as SVG at the width of the container, because text must stay legible on a phone.
import { make, svg } from "./dom.js";

const INKS = ["path", "hit", "miss", "ink", "blue", "red"].map((name) => `var(--${name})`);
const DASHES = ["", "6 3", "2 2.5", "8 3 2 3"];  // distinguish curves without color
const LETTER = 6.4;  // [px]; mean width of a character at 11.5 px

/** Draw a chart in an element, and return the chart; `setCursor` and `update` change the chart. @param {HTMLElement} home @param {ChartSpec} spec */
export const chart = (home, spec) => new Chart(home, spec);

/** Return at most `most` evenly spaced round numbers in a range. @param {number} low @param {number} high @param {number} most */
export function ticks(low, high, most) {
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = [1, 2, 2.5, 5, 10, 20].map((factor) => factor * power).find((size) => (high - low) / size <= most), found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(10)));
  return found;
}

/** Format a value with a reasonable number of digits. @param {number | null | undefined} value */
export function words(value) {
  if (!isNumber(value)) return "";
  if (Math.abs(value) >= 100 || Math.abs(value - Math.round(value)) < 1e-4) return String(Math.round(value) + 0);
  return Math.abs(value) < 0.1 ? String(Number(value.toPrecision(2))) : value.toFixed(2);
}

const isNumber = (value) => typeof value === "number" && Number.isFinite(value);

/** Return the lowest and highest number of a list of any length; null without numbers. */
function extent(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (isNumber(value)) { low = Math.min(low, value); high = Math.max(high, value); }
  return low <= high ? [low, high] : null;
}

/** Base of all drawings: title, legend, and an SVG that is drawn again when the width of the container changes. */
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

  /** Draw everything; subclasses override this method. */
  paint() {}

  /** Start an empty drawing with a height [px]. */
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

  /** Lay out the axes and set `x` and `y`, which convert values to pixels. */
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
    let free = -Infinity;  // a label that would touch the previous label is left out
    for (const [at, content] of xTicks) {
      const half = LETTER * String(content).length / 2, x = Math.min(Math.max(this.x(at), half + 1), this.width - half - 1);
      if (x - half < free) continue;
      this.text(x, bottom + 16, content);
      free = x + half + 6;
    }
    if (xLabel) this.text((left + right) / 2, this.height - 5, xLabel);
    if (yLabel) this.text(0, 0, yLabel, "middle", { transform: `translate(11 ${(top + bottom) / 2}) rotate(-90)` });
  }

  /** Shorten a name to fit below the x axis, where `others` labels share the width. */
  shortened(name, others) {
    const most = Math.max(3, Math.floor(((this.box.right - this.box.left) / others - 4) / LETTER));
    return name.length > most ? `${name.slice(0, most - 1)}\u2026` : name;
  }

  /** Return the width to reserve for the labels of the y axis [px]. */
  room(labels) { return 12 + LETTER * Math.max(1, ...labels.map((one) => String(one).length)) + (this.spec.yLabel ? 16 : 0); }

  /** Return the position of a pointer in pixels of the drawing. */
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

  /** Replace the drawn values. @param {SeriesSpec[]} series */
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

  /** Show a cursor at x, and the values of all series at the cursor; null hides the cursor. @param {number | null} x */
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

  /** Return the smallest distance between two x values of a series, for the width of bars and names. */
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
    for (const [x, y] of points) {
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

  /** Draw the cursor and write the values at the cursor. */
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

/** Split a list at null entries, and return the parts with more than one entry. */
function runs(list) {
  const found = [[]];
  for (const one of list) if (one) found.at(-1).push(one); else found.push([]);
  return found.filter((part) => part.length > 1);
}
