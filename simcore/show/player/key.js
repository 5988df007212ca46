// Legend of the marks in the view from above.
import { AWAY } from "./data.js";
import { make, svg } from "./dom.js";

const ink = (name) => `var(--${name})`;

/** Make the entries of the legend, each with a mark and the meaning of the mark. @param {import("./data.js").Run} run */
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
  if (believes) found.push(entry("where it believed it was", stroke(ink("ghost"), 3, "7 4")));
  if (shots.length) {
    found.push(entry(`hit${count("hit")}`, stroke(ink("hit"), 2), svg("circle", { cx: 12, r: 4, fill: ink("hit"), stroke: ink("paper") })));
    found.push(entry(`miss${count("miss")}`, stroke(ink("miss"), 2, "6 4"), svg("path", { d: "M7 -5l10 10m0 -10l-10 10", stroke: ink("miss"), "stroke-width": 2.3 })));
  }
  if (taken.length) found.push(entry(`taken in${areRuns ? "" : ` (${taken.length})`}`, svg("path", { d: "M-5 0h10m-5 -5v10", stroke: ink("path"), "stroke-width": 2 })));
  return found;
}
