// The field from above, as SVG in centimeters, y down: what moves, over the ground.
import { turned, yawOf } from "./data.js";
import { svg } from "./dom.js";
import { fieldCounts, ghostSymbol, ground, heatMap, robotSymbol, viewOf } from "./symbols.js";

const HIGH = 0.35;  // [m]; a flying piece whose center is higher is drawn darker and larger
const LATELY = 5;  // [s] for which trails stay

/** Outline of a turned box from above: length, width and heading of the rectangle along its longest edge.
 * @param {Point} size @param {Quaternion} quat */
export function rectangle([sx, sy, sz], [x, y, z, w]) {
  const edges = [[sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + w * z)], [sy * 2 * (x * y - w * z), sy * (1 - 2 * (x * x + z * z))],
    [sz * 2 * (x * z + w * y), sz * 2 * (y * z - w * x)]];
  const along = edges.reduce((one, other) => Math.hypot(...other) > Math.hypot(...one) ? other : one);
  const heading = Math.atan2(along[1], along[0]), cos = Math.cos(heading), sin = Math.sin(heading);
  const sum = (f) => edges.reduce((total, edge) => total + Math.abs(f(edge)), 0);
  return [sum(([u, v]) => cos * u + sin * v), sum(([u, v]) => cos * v - sin * u), heading];
}

export class Top {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.run = run;
    this.height = 100 * run.meta.field.size[1];
    this.trail = run.end - run.start < 31 && !run.meta.live ? "whole" : "lately";
    const { field, robots, levels } = run.meta, layer = (name) => [name, svg("g", { "data-layer": name })];
    this.layers = Object.fromEntries(["heat", "trails", "shots", "pieces", "lines", "ghosts", "robots", "flashes"].map(layer));
    this.drawing = svg("svg", { viewBox: viewOf(field).map((size) => size.toFixed(1)).join(" "), role: "img", "aria-label": "the field from above" },
      ...ground(field), ...Object.values(this.layers), fieldCounts(levels, this.height));
    home.replaceChildren(this.drawing);
    const named = robots.length > 1;
    this.layers.robots.append(...robots.map((robot, k) => robotSymbol(robot, named ? robot.name || String(k) : "")));
    this.layers.ghosts.append(...robots.map(ghostSymbol));
    this.robots = [...this.layers.robots.children];
    this.ghosts = [...this.layers.ghosts.children];
    this.nodes = run.pieces.map(({ kind }) => {
      const look = run.meta.kinds[kind];
      const node = look.round ? svg("circle", { r: 100 * look.radius }) : svg("rect", { x: -50, y: -50, width: 100, height: 100, "vector-effect": "non-scaling-stroke" });
      node.setAttribute("stroke", look.edge);
      node.setAttribute("stroke-width", "1.3");
      return node;
    });
    this.shown = this.nodes.map(() => "");
    this.homes = this.nodes.map(() => null);
  }

  draw(time) {
    const { run } = this;
    this.robots.forEach((node, k) => {
      const pose = run.robot(k, time), belief = pose && pose.belief;
      this.place(node, pose && [pose.place[0], pose.place[1], yawOf(pose.quat)]);
      this.place(this.ghosts[k], belief);
      node.classList.toggle("active", Boolean(pose && pose.active));
    });
    run.eachPiece(time, (row, x, y, z, state, rows, a, b, k) => this.putPiece(row, x, y, z, state, rows, a, b, k));
    this.drawTrails(time);
    this.drawShots(time);
    const lines = run.lines(time).map(([from, to]) => `M${this.xy(from)}L${this.xy(to)}`).join("");
    this.path(this.layers.lines, "sight", lines, { stroke: "#14c88c", "stroke-width": 2 });
  }

  /** @param {number[]} place */
  xy([x, y]) { return `${(100 * x).toFixed(1)} ${(this.height - 100 * y).toFixed(1)}`; }

  place(node, pose) {
    node.setAttribute("visibility", pose ? "visible" : "hidden");
    if (!pose) return;
    const degrees = pose[2] * 180 / Math.PI, label = node.querySelector(".label");
    node.setAttribute("transform", `translate(${this.xy(pose)}) rotate(${(-degrees).toFixed(1)})`);
    if (label) label.setAttribute("transform", `rotate(${degrees.toFixed(1)})`);
  }

  putPiece(row, x, y, z, state, rows, a, b, k) {
    const node = this.nodes[row], look = this.run.meta.kinds[this.run.pieces[row].kind], isAway = state === 0;
    const isHigh = state === 2 && z > HIGH, scale = isHigh ? Math.min(1.6, 1.15 + 0.25 * (z - HIGH)) : 1;
    let words = "";
    if (!isAway) {
      words = state > 2 ? `translate(${(100 * x).toFixed(1)} ${(-100 * y).toFixed(1)})` : `translate(${this.xy([x, y])})`;
      if (look.round) words += scale === 1 ? "" : ` scale(${scale.toFixed(2)})`;
      else {
        const [length, width, heading] = rectangle(look.size, turned(rows, a, b, k));
        words += ` rotate(${(-heading * 180 / Math.PI).toFixed(1)}) scale(${(scale * length).toFixed(3)} ${(scale * width).toFixed(3)})`;
      }
    }
    const key = words + state + isHigh;
    if (this.shown[row] === key) return;
    this.shown[row] = key;
    const home = isAway ? null : state > 2 ? this.robots[state - 3] && this.robots[state - 3].querySelector(".held") : this.layers.pieces;
    if (home) {
      node.setAttribute("transform", words);
      node.setAttribute("fill", isHigh ? look.air : look.color);
    }
    if (this.homes[row] !== home) {
      if (home) home.appendChild(node); else node.remove();
      this.homes[row] = home;
    }
  }

  path(layer, name, d, look) {
    let node = layer.querySelector(`[data-name="${name}"]`);
    if (!node) {
      node = svg("path", { fill: "none", "data-name": name, ...look });
      layer.appendChild(node);
    }
    if (node.getAttribute("d") !== d) node.setAttribute("d", d);
  }

  drawTrails(time) {
    this.run.meta.robots.forEach((robot, k) => {
      const isWhole = this.trail === "whole" || this.trail === String(k);
      const from = isWhole ? this.run.start : time - LATELY, step = Math.max(0.1, (time - from) / 300);
      const ways = this.trail === "none" ? [] : this.run.pathOf(k, from, time, step);
      const d = ways.map((way) => way.map((place, i) => (i ? "L" : "M") + this.xy(place)).join("")).join("");
      this.path(this.layers.trails, `robot${k}`, d, { stroke: robot.ink, "stroke-width": 5, opacity: 0.7, "stroke-linejoin": "round" });
    });
  }

  drawShots(time) {
    const parts = { hit: "", miss: "", pass: "", flying: "" }, marks = { hit: "", miss: "", taken: "" };
    const isWhole = this.trail === "whole";
    for (const shot of this.trail === "none" ? [] : this.run.meta.shots) {
      const mine = this.trail === String(shot.robot);
      if (shot.time > time || (!isWhole && !mine && shot.end < time - LATELY)) continue;
      const way = this.run.wayOf(shot.piece, shot.time, Math.min(time, shot.end));
      if (!way.length) continue;
      parts[shot.result] += way.map((place, i) => (i ? "L" : "M") + this.xy(place)).join("");
      if (shot.end > time) continue;
      const [x, y] = this.xy(way.at(-1)).split(" ");
      if (shot.result === "hit") marks.hit += `M${x} ${y}m-6 0a6 6 0 1 0 12 0a6 6 0 1 0 -12 0`;
      if (shot.result === "miss") marks.miss += `M${x} ${y}m-7 -7l14 14m0 -14l-14 14`;
    }
    for (const [at, x, y] of this.trail === "none" ? [] : this.run.meta.taken) {
      if (at <= time && (isWhole || at > time - LATELY)) marks.taken += `M${this.xy([x, y])}m-5 0h10m-5 -5v10`;
    }
    const look = { "stroke-width": 2.5, opacity: 0.85 };
    this.path(this.layers.shots, "hit", parts.hit, { stroke: "var(--hit)", ...look });
    this.path(this.layers.shots, "miss", parts.miss, { stroke: "var(--miss)", "stroke-dasharray": "10 6", ...look });
    this.path(this.layers.shots, "pass", parts.pass, { stroke: "var(--muted)", "stroke-dasharray": "2 5", ...look });
    this.path(this.layers.shots, "flying", parts.flying, { stroke: "var(--muted)", "stroke-dasharray": "3 4", ...look });
    this.path(this.layers.shots, "hits", marks.hit, { stroke: "var(--paper)", "stroke-width": 1, style: "fill: var(--hit)" });
    this.path(this.layers.shots, "misses", marks.miss, { stroke: "var(--miss)", "stroke-width": 3 });
    this.path(this.layers.shots, "taken", marks.taken, { stroke: "var(--path)", "stroke-width": 2 });
  }

  /** What can be shown as a heat map, by name: where robots were, and where shots came down that missed. */
  heatMaps() {
    const { run } = this, { meta } = run, driven = [], fallen = [];
    for (const time of run.groups.robots.times.subarray(0, run.groups.robots.n)) {
      meta.robots.forEach((_, k) => { const pose = run.robot(k, time); if (pose) driven.push(pose.place); });
    }
    for (const shot of meta.shots) if (shot.result === "miss") fallen.push(...run.wayOf(shot.piece, shot.time, shot.end).slice(-1));
    /** @type {Record<string, [number[][], string]>} */
    const maps = { robot: [driven, "path"], misses: [fallen, "miss"] };
    return Object.fromEntries(Object.entries(maps).filter(([, [places]]) => places.length)
      .map(([name, [places, color]]) => [name, heatMap(meta.field.size, places, color)]));
  }

  /** A ring where something has scored. @param {ArrayLike<number>} place */
  flash(place) {
    const ring = svg("circle", { cx: 100 * place[0], cy: this.height - 100 * place[1], r: 12, class: "flash" });
    this.layers.flashes.appendChild(ring);
    setTimeout(() => ring.remove(), 700);
  }
}
