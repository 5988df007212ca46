// Draws a described robot from above and from its right side, to one scale in meters.
import { Drawing, ticks } from "./charts.js";
import { make, svg } from "./dom.js";

const PAPER = "#eceef0", INK = "#20242b";  // of both themes: the robot's colors are made for light
const MARGIN = 0.1;  // [m]
/** Name, axis that goes up, axis along the look. @type {[string, number, number][]} */
const VIEWS = [["from above", 1, 2], ["from its right side", 2, 1]];

/** Draw a robot. @param {HTMLElement} home @param {RobotSpec} spec */
export const robotViews = (home, spec) => new RobotViews(home, spec);

/** The triangles of a solid as one path, all in one turning sense, so that they add up to its shadow.
 * @param {[number, number][]} places @param {[number, number, number][]} faces */
export function shadow(places, faces) {
  let d = "";
  for (const [i, j, k] of faces) {
    const [a, b, c] = [places[i], places[j], places[k]], area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if (Math.abs(area) < 1e-3) continue;
    d += `M${[a, ...area > 0 ? [b, c] : [c, b]].map(([x, y]) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}Z`;
  }
  return d;
}

class RobotViews extends Drawing {
  constructor(home, spec) {
    super(home, spec);
    const named = new Map(spec.solids.filter(({ name }) => name).map(({ name, color, opacity }) => [name, [color, opacity]]));
    this.legend.replaceChildren(...[...named].map(([name, [color, opacity]]) => {
      const sample = svg("svg", { viewBox: "0 0 20 8", "aria-hidden": "true" }, svg("rect", { width: 20, height: 8, fill: PAPER }), svg("rect", { width: 20, height: 8, fill: color, "fill-opacity": Math.max(0.4, opacity) }));
      return make("span", {}, sample, ` ${name}`);
    }));
  }

  paint() {
    const { solids } = this.spec, all = solids.flatMap(({ points }) => points);
    const low = [0, 1, 2].map((axis) => all.reduce((least, point) => Math.min(least, point[axis]), 0) - MARGIN);
    const high = [0, 1, 2].map((axis) => all.reduce((most, point) => Math.max(most, point[axis]), 0) + MARGIN);
    const isWide = this.width > 700, left = 36, gap = 24;
    const each = isWide ? (this.width - gap) / 2 : this.width, scale = (each - left - 8) / (high[0] - low[0]);
    const tall = VIEWS.map(([, up]) => (high[up] - low[up]) * scale);
    this.begin(Math.ceil(isWide ? Math.max(...tall) + 44 : tall[0] + tall[1] + 88));
    let [x, y] = [left, 20];
    VIEWS.forEach((view, number) => {
      this.view(view, { x, y, scale, low, high });
      if (isWide) x += each + gap; else y += tall[number] + 44;
    });
  }

  view([name, up, deep], { x, y, scale, low, high }) {
    const right = x + (high[0] - low[0]) * scale, bottom = y + (high[up] - low[up]) * scale;
    const at = (point) => [x + (point[0] - low[0]) * scale, bottom - (point[up] - low[up]) * scale];
    this.text(x, y - 6, name, "start", { fill: "var(--ink)", "font-weight": 600 });
    this.put("rect", { x, y, width: right - x, height: bottom - y, fill: PAPER });
    for (const value of ticks(low[0], high[0], 8)) {
      const [across] = at([value, 0, 0]);
      this.put("path", { d: `M${across} ${y}V${bottom}`, stroke: value === 0 ? "#9aa1aa" : "#d5d8dc" });
      this.text(across, bottom + 15, value);
    }
    for (const value of ticks(low[up], high[up], 8)) {
      const [, level] = at([0, value, value]);
      this.put("path", { d: `M${x} ${level}H${right}`, stroke: value === 0 ? "#9aa1aa" : "#d5d8dc" });
      this.text(x - 5, level + 4, value, "end");
    }
    const depth = ({ points }) => points.reduce((sum, point) => sum + point[deep], 0) / points.length * (deep === 2 ? 1 : -1);
    for (const solid of [...this.spec.solids].sort((one, other) => depth(one) - depth(other))) {
      this.put("path", { d: shadow(solid.points.map(at), solid.faces), fill: solid.color, "fill-opacity": solid.opacity });
    }
    const [tip, middle] = at([high[0] - 0.25 * MARGIN, 0, up === 1 ? 0 : low[2] + MARGIN / 2]);
    this.text(tip, middle + 4, "front \u25b6", "end", { fill: INK, "font-weight": 600, style: `stroke: ${PAPER}` });
  }
}
