// What the view from above is made of, as SVG in centimeters, y down: the ground, robots, marks and their key.
import { ticks } from "./charts.js";
import { AWAY, yawOf } from "./data.js";
import { make, svg } from "./dom.js";

const MARGIN = 78;  // [cm] around the field, where its scale is written
const MOST = 150;  // [cm] that is seen beside the field
const BUMPER = 8;  // [cm] wide, as drawn
const LINE = 21;  // [cm] between the counts of two levels
const ink = (name) => `var(--${name})`;

/** What is seen: left, top, width and height [cm] with all that stands at the field's edge. @param {Meta["field"]} field */
export function viewOf({ size, outlines }) {
  const [length, width] = size.map((one) => 100 * one);
  const low = [-1.25 * MARGIN, -MARGIN / 2], high = [length + MARGIN / 2, width + 0.85 * MARGIN];
  for (const [, , , corners] of outlines) {
    for (const [x, y] of corners) {
      [100 * x, width - 100 * y].forEach((at, k) => { low[k] = Math.min(low[k], at); high[k] = Math.max(high[k], at); });
    }
  }
  const from = low.map((at) => Math.max(-MOST, at)), to = [length, width].map((size_, k) => Math.min(size_ + MOST, high[k]));
  return [...from, to[0] - from[0], to[1] - from[1]];
}

const text = (x, y, size, words, more = {}) => svg("text", { x, y, "font-size": size, fill: ink("muted"), ...more }, words);
const polygon = (corners, look, ...inside) => svg("polygon", { points: corners.map((one) => one.map((at) => at.toFixed(1)).join(",")).join(" "), ...look }, ...inside);
const middle = (marks) => marks.length > 1 ? 0.5 * (marks.at(-1) + marks.at(-2)) : 0.5 * (marks[0] ?? 0);

/** Carpet, walls, elements, tags, and the scale in meters. @param {Meta["field"]} field */
export function ground(field) {
  const [length, width] = field.size.map((size) => 100 * size), left = viewOf(field)[0];
  const along = ticks(0, field.size[0], 9), up = ticks(0, field.size[1], 6), scale = [], marks = svg("g");
  const line = (x1, y1, x2, y2, stroke, size = 1) => marks.append(svg("line", { x1, y1, x2, y2, stroke, "stroke-width": size }));
  marks.append(svg("rect", { width: length, height: width, fill: ink("carpet") }));
  for (const x of along) {
    line(100 * x, 0, 100 * x, width, ink("seams"));
    scale.push(text(100 * x, width + 54, 22, String(x), { "text-anchor": "middle" }));
  }
  for (const y of up) {
    line(0, width - 100 * y, length, width - 100 * y, ink("seams"));
    scale.push(text(-38, width - 100 * y + 7, 22, String(y), { "text-anchor": "end" }));
  }
  scale.push(text(100 * middle(along), width + 54, 22, "x [m]", { "text-anchor": "middle", class: "axis" }));
  scale.push(text(left + 2, width - 100 * middle(up) + 7, 22, "y [m]", { class: "axis" }));
  for (const [name, side, , corners] of field.outlines) {
    const look = { fill: ink(`${side}-fill`), stroke: ink(side), "stroke-width": 1.5, opacity: 0.8 };
    marks.append(polygon(corners.map(([x, y]) => [100 * x, width - 100 * y]), look, svg("title", {}, name)));
  }
  for (const y of [0, width]) line(0, y, length, y, ink("ink"), 3);
  line(0, 0, 0, width, ink("blue"), 6);
  line(length, 0, length, width, ink("red"), 6);
  for (const [id, x, y, , w, a, b, c] of field.tags) {
    const yaw = yawOf([a, b, c, w]), half = 50 * field.tag_size, across = [half * Math.sin(yaw), half * Math.cos(yaw)];
    marks.append(svg("line", { x1: 100 * x - across[0], y1: width - 100 * y - across[1], x2: 100 * x + across[0], y2: width - 100 * y + across[1],
      stroke: ink("ink"), "stroke-width": 4, class: "tag" }, svg("title", {}, `tag ${id}`)));
  }
  return [marks, svg("g", { class: "scale" }, ...scale)];
}

/** Arrow from the back of a robot whose tip is at its front edge. */
function arrow(length, width) {
  const neck = 0.5 * length - BUMPER - 0.34 * length, head = 0.17 * width;
  return [[length / 2 - BUMPER, 0], [neck, head], [neck, -head]];
}

/** A robot with its front to the right: bumpers, intakes that are out, what it holds, and a label that stays upright.
 * @param {RobotData} robot @param {string} label */
export function robotSymbol(robot, label) {
  const [length, width] = robot.size.map((size) => 100 * size), side = robot.alliance || "neutral", tip = arrow(length, width);
  const [fill, edge] = robot.own_ink ? [robot.own_ink, robot.own_ink] : [ink(`${side}-fill`), ink(side)];
  const inner = { x: -length / 2 + BUMPER, y: -width / 2 + BUMPER, width: length - 2 * BUMPER, height: width - 2 * BUMPER, rx: 2 };
  const node = svg("g", { class: "robot" },
    ...robot.intakes.map((zone) => polygon(zone.map(([x, y]) => [100 * x, -100 * y]), { class: "intake", fill: ink("path"),
      "fill-opacity": 0.25, stroke: ink("path"), "stroke-width": 2, "stroke-dasharray": "5 4" })),
    svg("rect", { x: -length / 2, y: -width / 2, width: length, height: width, rx: 5, fill: edge, stroke: ink("paper") }),
    svg("rect", { ...inner, fill }), svg("rect", { ...inner, fill: ink("paper"), opacity: 0.72 }), svg("g", { class: "held" }),
    svg("line", { x1: -0.5 * length + 2 * BUMPER, x2: tip[1][0], stroke: edge, "stroke-width": 5, opacity: 0.9 }),
    polygon(tip, { fill: edge, stroke: ink("paper") }));
  if (label) {
    const reach = Math.max(17, 8 * label.length + 6);
    node.append(svg("g", { class: "label" },
      svg("rect", { x: -reach, y: -17, width: 2 * reach, height: 34, rx: 17, fill: ink("paper"), stroke: edge, "stroke-width": 2 }),
      text(0, 9.5, 27, label, { fill: ink("ink"), "text-anchor": "middle", "font-weight": "bold" })));
  }
  return node;
}

/** Outline of a robot where it believes to be. @param {RobotData} robot */
export function ghostSymbol(robot) {
  const [length, width] = robot.size.map((size) => 100 * size);
  const look = { fill: "none", stroke: ink("ghost"), "stroke-width": 3, "stroke-dasharray": "9 6" };
  return svg("g", { class: "ghost" }, svg("rect", { x: -length / 2, y: -width / 2, width: length, height: width, rx: 5, ...look }), polygon(arrow(length, width), look));
}

/** How many pieces the levels have, in the middle of their places. @param {LevelData[]} levels @param {number} height [cm] */
export function fieldCounts(levels, height) {
  /** @type {Map<string, LevelData[]>} */
  const spots = new Map();
  for (const level of levels) {
    const spot = level.middle && level.middle.map((at) => Math.round(4 * at)).join();
    if (spot) spots.set(spot, [...spots.get(spot) ?? [], level]);
  }
  return svg("g", { class: "counts" }, ...[...spots.values()].flatMap((mine) => {
    const [x, y] = mine[0].middle, top = height - 100 * y - 0.5 * LINE * mine.length;
    const reach = 6.5 * Math.max(...mine.map(({ label }) => label.length)) + 18;
    return [svg("rect", { x: 100 * x - reach, y: top - 3, width: 2 * reach, height: LINE * mine.length + 6, rx: 8, fill: ink("paper"), opacity: 0.85, stroke: ink(mine[0].alliance || "neutral") }),
      ...mine.map(({ name, label }, row) => svg("g", { "data-cell": name, transform: `translate(${100 * x + reach - 25} ${top + LINE * (row + 0.75)})` },
        text(-4, 0, 20, label, { "text-anchor": "end" }), text(5, 0, 20, "0", { class: "n", fill: ink("ink"), "font-weight": "bold" })))];
  }));
}

/** Squares of half a meter, the denser the more of some places [m] are in them; places beside the field count at its edge.
 * @param {[number, number]} size @param {number[][]} places */
export function heatMap([length, width], places, color, cell = 0.5) {
  const counts = new Map();
  for (const [x, y] of places) {
    const at = [[x, length], [y, width]].map(([value, most]) => Math.floor(Math.min(Math.max(value, 0), most - 1e-6) / cell)).join();
    counts.set(at, (counts.get(at) ?? 0) + 1);
  }
  const most = Math.max(1, ...counts.values());
  return svg("g", { fill: ink(color) }, ...[...counts].map(([at, count]) => {
    const [i, k] = at.split(",").map(Number);
    return svg("rect", { x: 100 * i * cell, y: 100 * (width - (k + 1) * cell), width: 100 * cell, height: 100 * cell, opacity: (0.2 + 0.7 * Math.sqrt(count / most)).toFixed(2) },
      svg("title", {}, `${count} at x ${(i + 0.5) * cell} m, y ${(k + 0.5) * cell} m`));
  }));
}

/** What each mark means, in words that stand next to it. @param {import("./data.js").Run} run */
export function keyOf(run) {
  const { meta } = run, { robots, shots, taken } = meta, areRuns = robots.some((robot) => robot.is_run);
  const count = (result) => areRuns ? "" : ` (${shots.filter((shot) => shot.result === result).length})`;
  const stroke = (color, width, dashes = null) => svg("line", { x1: -12, x2: 12, stroke: color, "stroke-width": width, "stroke-dasharray": dashes });
  const entry = (words, ...marks) => make("span", {}, svg("svg", { viewBox: "-14 -8 32 16", "aria-hidden": "true" }, ...marks), ` ${words}`);
  const found = meta.looks.map(({ name, box, color, edge }) => entry(name, box ?
    svg("rect", { x: -7, y: -5, width: 14, height: 10, fill: color, stroke: edge }) : svg("circle", { r: 6, fill: color, stroke: edge })));
  if (areRuns) for (const robot of robots) found.push(entry(`path, ${robot.name}`, stroke(robot.ink, 4)));
  else if (robots.length === 1) found.push(entry("path", stroke(robots[0].ink, 4)));
  else for (const side of [...new Set(robots.map((robot) => robot.alliance))].sort()) found.push(entry(`path of a ${side} robot`, stroke(ink(side), 4)));
  const { rows, width, n } = run.groups.robots;
  const believes = robots.some((_, k) => { for (let i = 0; i < n; i++) if (rows[i * width + 11 * k + 7] !== AWAY) return true; return false; });
  if (believes) found.push(entry("where it believed to be", stroke(ink("ghost"), 3, "7 4")));
  if (shots.length) {
    found.push(entry(`hit${count("hit")}`, stroke(ink("hit"), 2), svg("circle", { cx: 12, r: 4, fill: ink("hit"), stroke: ink("paper") })));
    found.push(entry(`miss${count("miss")}`, stroke(ink("miss"), 2, "6 4"), svg("path", { d: "M7 -5l10 10m0 -10l-10 10", stroke: ink("miss"), "stroke-width": 2.3 })));
  }
  if (taken.length) found.push(entry(`taken in${areRuns ? "" : ` (${taken.length})`}`, svg("path", { d: "M-5 0h10m-5 -5v10", stroke: ink("path"), "stroke-width": 2 })));
  return found;
}
