// View of the field from above on a canvas, in meters with y up: moving objects on a background that is drawn once.
import { ticks } from "./charts.js";
import { turned, yawOf } from "./data.js";
import { make } from "./dom.js";

const MARGIN = 0.78, LEAST = 0.12;  // [m] around the field, with and without the scale
const MOST = 1.5;  // [m]; largest visible margin outside the field
const BUMPER = 0.08;  // [m]; drawn width of bumpers
const HIGH = 0.35;  // [m]; a flying piece whose center is higher is drawn darker and larger
const LATELY = 5;  // [s]; length of trails
const SMALL = 620;  // [px]; a narrower view has neither scale nor counts
const FLASH = 700;  // [ms]
const TURN = 2 * Math.PI;

/** Return a color of the page, by name or as `var(--name)`. @param {string} name */
export function ink(name) {
  const own = name.match(/^var\(--([\w-]+)\)$/);
  return name[0] === "#" ? name : getComputedStyle(document.documentElement).getPropertyValue(`--${own ? own[1] : name}`).trim();
}

/** Return the visible area, including elements outside the field: left, low, right and high limit [m]. @param {Meta["field"]} field */
export function viewOf({ size, outlines }, margin = MARGIN) {
  const low = [-1.25 * margin, -0.85 * margin], high = [size[0] + margin / 2, size[1] + margin / 2];
  for (const [, , corners] of outlines) {
    for (const corner of corners) corner.forEach((at, k) => { low[k] = Math.min(low[k], at); high[k] = Math.max(high[k], at); });
  }
  return [...low.map((at) => Math.max(-MOST, at)), ...high.map((at, k) => Math.min(size[k] + MOST, at))];
}

/** Return the outline of a rotated box seen from above: length, width and heading of a rectangle along the longest edge.
 * @param {Point} size @param {Quaternion} quat */
export function rectangle([sx, sy, sz], [x, y, z, w]) {
  const edges = [[sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + w * z)], [sy * 2 * (x * y - w * z), sy * (1 - 2 * (x * x + z * z))],
    [sz * 2 * (x * z + w * y), sz * 2 * (y * z - w * x)]];
  const along = edges.reduce((one, other) => Math.hypot(...other) > Math.hypot(...one) ? other : one);
  const heading = Math.atan2(along[1], along[0]), cos = Math.cos(heading), sin = Math.sin(heading);
  const sum = (f) => edges.reduce((total, edge) => total + Math.abs(f(edge)), 0);
  return [sum(([u, v]) => cos * u + sin * v), sum(([u, v]) => cos * v - sin * u), heading];
}

/** Count the positions [m] in each square of the field; positions outside the field count at the edge.
 * @param {[number, number]} size @param {number[][]} places @returns {[number, number, number][]} corner [m] and count */
export function squares([length, width], places, cell = 0.5) {
  const counts = new Map();
  for (const [x, y] of places) {
    const at = [[x, length], [y, width]].map(([value, most]) => Math.floor(Math.min(Math.max(value, 0), most - 1e-6) / cell)).join();
    counts.set(at, (counts.get(at) ?? 0) + 1);
  }
  return [...counts].map(([at, count]) => { const [i, k] = at.split(",").map(Number); return [i * cell, k * cell, count]; });
}

export class Top {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.run = run;
    this.home = home;
    this.trail = run.end - run.start < 31 && !run.meta.live ? "whole" : "lately";
    this.chosen = run.meta.robots.length === 1 ? 0 : null;
    this.canvas = make("canvas", { role: "img", "aria-label": "the field from above" });
    this.pen = this.canvas.getContext("2d");
    this.floor = document.createElement("canvas");
    this.heat = null;
    this.flashes = [];
    home.replaceChildren(this.canvas);
    this.canvas.onpointermove = (event) => { this.canvas.title = this.nameAt(event); };
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.resize());
  }

  /** Fit the drawing to the container, or to a width and height [px], and draw the background again. */
  resize(width = this.home.clientWidth, height = this.home.clientHeight, sharp = Math.min(devicePixelRatio, 2)) {
    if (!width || !height) return;
    const { field } = this.run.meta, isSmall = width < SMALL, [left, low, right, high] = this.view = viewOf(field, isSmall ? LEAST : MARGIN);
    this.inks = new Map();
    this.hasWords = !isSmall;
    [this.canvas.width, this.canvas.height] = [this.floor.width, this.floor.height] = [Math.round(width * sharp), Math.round(height * sharp)];
    this.scale = Math.min(this.canvas.width / (right - left), this.canvas.height / (high - low));
    this.at = [0.5 * (this.canvas.width - this.scale * (left + right)), 0.5 * (this.canvas.height + this.scale * (low + high))];
    this.on(this.floor.getContext("2d"), () => this.ground());
  }

  /** Call a function that draws with another canvas context. */
  on(pen, draw) {
    const before = this.pen;
    this.pen = pen;
    this.toField();
    draw();
    this.pen = before;
  }

  toField() { this.pen.setTransform(this.scale, 0, 0, -this.scale, ...this.at); }

  ink(name) {
    if (!this.inks.has(name)) this.inks.set(name, ink(name));
    return this.inks.get(name);
  }

  /** Return the position of a pointer on the field [m]. */
  placeOf(event) {
    const box = this.canvas.getBoundingClientRect(), k = this.canvas.width / box.width;
    return [((event.clientX - box.left) * k - this.at[0]) / this.scale, (this.at[1] - (event.clientY - box.top) * k) / this.scale];
  }

  /** Return a text for the heat map square, the tag or the field element at a pointer. */
  nameAt(event) {
    const { outlines, tags } = this.run.meta.field, [x, y] = this.placeOf(event);
    const tag = tags.find((one) => Math.hypot(one[1] - x, one[2] - y) < 0.15);
    const heat = (this.heat || []).find(([u, v]) => x >= u && x < u + 0.5 && y >= v && y < v + 0.5);
    const isIn = (corners) => corners.reduce((inside, [a, b], k) => {
      const [c, d] = corners[(k + 1) % corners.length];
      return (b > y) !== (d > y) && x < (c - a) * (y - b) / (d - b) + a ? !inside : inside;
    }, false);
    return heat ? `${heat[2]} at x ${heat[0] + 0.25} m, y ${heat[1] + 0.25} m` : tag ? `tag ${tag[0]}` : (outlines.find((one) => isIn(one[2])) ?? [""])[0];
  }

  /** Return the number of the robot at a pointer, or null. */
  robotAt(event, time) {
    const [x, y] = this.placeOf(event), far = this.run.meta.robots.map((_, k) => { const pose = this.run.robot(k, time); return pose ? Math.hypot(pose.place[0] - x, pose.place[1] - y) : 9; });
    const nearest = far.indexOf(Math.min(...far));
    return far[nearest] < 0.6 ? nearest : null;
  }

  // --- shapes ---------------------------------------------------------------------------------------------------------

  shape(corners, isClosed = true) {
    corners.forEach(([x, y], k) => k ? this.pen.lineTo(x, y) : this.pen.moveTo(x, y));
    if (isClosed) this.pen.closePath();
  }

  paint({ fill = "", stroke = "", wide = 0.02, dash = [], alpha = 1 }, trace) {
    const { pen } = this;
    pen.globalAlpha = alpha;
    pen.beginPath();
    trace();
    if (fill) { pen.fillStyle = this.ink(fill); pen.fill(); }
    if (stroke) { pen.strokeStyle = this.ink(stroke); pen.lineWidth = Math.max(wide, 0.9 / this.scale); pen.setLineDash(dash); pen.stroke(); }
    pen.globalAlpha = 1;
  }

  line(x1, y1, x2, y2, stroke, wide) { this.paint({ stroke, wide }, () => this.shape([[x1, y1], [x2, y2]], false)); }

  /** Draw a text at a position [m] with a size [m], or larger if the text would be too small to read. */
  words(x, y, size, text, look = {}) {
    const { pen } = this, { color = "muted", align = "center", bold = false } = look;
    pen.save();
    pen.setTransform(1, 0, 0, 1, this.at[0] + this.scale * x, this.at[1] - this.scale * y);
    pen.font = `${bold ? 700 : 400} ${Math.max(size * this.scale, 10)}px system-ui, sans-serif`;
    Object.assign(pen, { fillStyle: this.ink(color), textAlign: align, textBaseline: "middle" });
    pen.fillText(text, 0, 0);
    pen.restore();
  }

  /** Draw carpet, elements, walls, tags and the scale in meters. */
  ground() {
    const { field } = this.run.meta, [length, width] = field.size, along = ticks(0, length, 9), up = ticks(0, width, 6);
    this.pen.clearRect(-9, -9, length + 18, width + 18);
    this.paint({ fill: "carpet" }, () => this.pen.rect(0, 0, length, width));
    for (const x of along) this.line(x, 0, x, width, "seams", 0.01);
    for (const y of up) this.line(0, y, length, y, "seams", 0.01);
    for (const [, side, corners] of field.outlines) this.paint({ fill: `${side}-fill`, stroke: side, wide: 0.015, alpha: 0.8 }, () => this.shape(corners));
    for (const y of [0, width]) this.line(0, y, length, y, "ink", 0.03);
    this.line(0, 0, 0, width, "blue", 0.06);
    this.line(length, 0, length, width, "red", 0.06);
    for (const [, x, y, , w, a, b, c] of field.tags) {
      const yaw = yawOf([a, b, c, w]), half = 0.5 * field.tag_size, across = [half * Math.sin(yaw), half * Math.cos(yaw)];
      this.line(x - across[0], y + across[1], x + across[0], y - across[1], "ink", 0.04);
    }
    if (!this.hasWords) return;
    for (const x of along) this.words(x, -0.48, 0.22, x === along.at(-1) ? `${x} m` : String(x));
    for (const y of up) this.words(-0.42, y, 0.22, y === up.at(-1) ? `${y} m` : String(y), { align: "right" });
  }

  // --- what moves -----------------------------------------------------------------------------------------------------

  draw(time) {
    if (!this.scale) return;
    const { run, pen } = this;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.floor, 0, 0);
    this.toField();
    const most = Math.max(1, ...(this.heat || []).map(([, , count]) => count));
    for (const [x, y, count] of this.heat || []) this.paint({ fill: this.heat.color, alpha: 0.2 + 0.7 * Math.sqrt(count / most) }, () => pen.rect(x, y, 0.5, 0.5));
    this.drawTrails(time);
    this.drawShots(time);
    const poses = run.meta.robots.map((_, k) => run.robot(k, time)), held = poses.map(() => []), lying = [], flying = [];
    run.eachPiece(time, (row, x, y, z, state, rows, a, b, k) => {
      if (!state) return;
      const { kind } = run.pieces[row], quat = run.meta.kinds[kind].round ? null : turned(rows, a, b, k);
      (state > 2 ? held[state - 3] ?? [] : state === 2 && z > HIGH ? flying : lying).push([kind, x, y, quat, state === 2 && z > HIGH ? Math.min(1.6, 1.15 + 0.25 * (z - HIGH)) : 1]);
    });
    this.pieces(lying, "color");
    this.paint({ stroke: "#14c88c", wide: 0.02 }, () => { for (const ends of run.lines(time)) this.shape(ends, false); });
    poses.forEach((pose, k) => { if (pose && pose.belief && k === this.chosen) this.ghost(run.meta.robots[k], pose.belief); });
    poses.forEach((pose, k) => { if (pose) this.robot(run.meta.robots[k], k, pose, held[k]); });
    this.pieces(flying, "air");
    this.flashes = this.flashes.filter(([, since]) => performance.now() - since < FLASH);
    for (const [place, since] of this.flashes) {
      const share = (performance.now() - since) / FLASH;
      this.paint({ stroke: "hit", wide: 0.08 * (1 - share), alpha: 1 - share }, () => pen.arc(place[0], place[1], 0.12 + 0.58 * share, 0, TURN));
    }
    if (this.hasWords) this.counts(time);
  }

  /** Draw pieces, given as [kind, x, y, quaternion or null, scale]. */
  pieces(list, color) {
    this.run.meta.kinds.forEach((look, kind) => {
      const mine = list.filter((one) => one[0] === kind), r = this.hasWords ? look.radius : 0.8 * look.radius;
      if (!mine.length) return;
      this.paint({ fill: look[this.hasWords ? color : "air"], stroke: this.hasWords ? look.edge : "", wide: 0.013 }, () => {
        for (const [, x, y, quat, scale] of mine) {
          if (look.round) { this.pen.moveTo(x + scale * r, y); this.pen.arc(x, y, scale * r, 0, TURN); } else this.turnedPiece(look, x, y, quat, scale);
        }
      });
    });
  }

  turnedPiece(look, x, y, quat, scale) {
    const { pen } = this, [length, width, heading] = rectangle(look.size, quat), cos = scale * Math.cos(heading) / 2, sin = scale * Math.sin(heading) / 2;
    if (look.hole === null) return this.shape([[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([u, v]) => [x + u * length * cos - v * width * sin, y + u * length * sin + v * width * cos]));
    // a body of revolution; the edge and the hole of a ring are ellipses
    const [a, b, c, d] = quat, up = Math.abs(1 - 2 * (a * a + b * b)), tilt = Math.atan2(2 * (b * c - d * a), 2 * (a * c + d * b));
    for (const [r, flat] of [[look.size[0] / 2, Math.sqrt(1 - up * up) * look.size[2] / 2], [look.hole, 0]]) {
      if (!r) continue;
      pen.moveTo(x - scale * r * Math.sin(tilt), y + scale * r * Math.cos(tilt));
      pen.ellipse(x, y, scale * Math.max(r * up, flat), scale * r, tilt, Math.PI / 2, Math.PI / 2 + (flat || !look.hole || r !== look.hole ? TURN : -TURN), r === look.hole);
    }
    return undefined;
  }

  within([x, y, yaw], draw) {
    this.pen.save();
    this.pen.translate(x, y);
    this.pen.rotate(yaw);
    draw();
    this.pen.restore();
  }

  arrow([length, width]) {
    const neck = 0.16 * length - BUMPER, head = 0.17 * width;
    this.shape([[length / 2 - BUMPER, 0], [neck, head], [neck, -head]]);
  }

  robot(robot, number, pose, held) {
    const [length, width] = robot.size, side = robot.alliance || "neutral", { pen } = this;
    const [fill, edge] = robot.own_ink ? [robot.own_ink, robot.own_ink] : [`${side}-fill`, side];
    this.within([pose.place[0], pose.place[1], yawOf(pose.quat)], () => {
      if (pose.active) for (const zone of robot.intakes) this.paint({ stroke: "path", wide: 0.02, dash: [0.05, 0.04] }, () => this.shape(zone));
      this.paint({ fill: edge, stroke: number === this.chosen && this.run.meta.robots.length > 1 ? "ink" : "paper", wide: 0.03 }, () => pen.roundRect(-length / 2, -width / 2, length, width, 0.05));
      const inner = [-length / 2 + BUMPER, -width / 2 + BUMPER, length - 2 * BUMPER, width - 2 * BUMPER];
      this.paint({ fill }, () => pen.rect(...inner));
      this.paint({ fill: "paper", alpha: 0.72 }, () => pen.rect(...inner));
      this.pieces(held, "color");
      this.paint({ stroke: edge, wide: 0.05, alpha: 0.9 }, () => this.shape([[-length / 2 + 2 * BUMPER, 0], [0.1 * length - BUMPER, 0]], false));
      this.paint({ fill: edge, stroke: "paper", wide: 0.01 }, () => this.arrow(robot.size));
    });
    if (this.run.meta.robots.length < 2) return;
    const [x, y] = pose.place, size = Math.max(this.hasWords ? 0.27 : 0.42, 11 / this.scale), reach = Math.max(0.63, 0.3 * robot.label.length + 0.22) * size;
    this.paint({ fill: "paper", stroke: edge, wide: 0.02 }, () => pen.roundRect(x - reach, y - 0.63 * size, 2 * reach, 1.26 * size, 0.6 * size));
    this.words(x, y - 0.02, size, robot.label, { color: "ink", bold: true });
  }

  /** Draw the outline of a robot at its estimated pose. */
  ghost(robot, belief) {
    const [length, width] = robot.size, look = { stroke: "ghost", wide: 0.03, dash: [0.09, 0.06] };
    this.within(belief, () => {
      this.paint(look, () => this.pen.roundRect(-length / 2, -width / 2, length, width, 0.05));
      this.paint(look, () => this.arrow(robot.size));
    });
  }

  drawTrails(time) {
    if (this.trail === "none") return;
    this.run.meta.robots.forEach((robot, k) => {
      const isWhole = this.trail === "whole" || this.trail === String(k), from = isWhole ? this.run.start : time - LATELY;
      this.paint({ stroke: robot.ink, wide: 0.05, alpha: 0.7 }, () => {
        for (const way of this.run.pathOf(k, from, time, Math.max(0.1, (time - from) / 300))) this.shape(way, false);
      });
    });
  }

  drawShots(time) {
    if (this.trail === "none") return;
    const isWhole = this.trail === "whole", ways = { hit: [], miss: [], pass: [], flying: [] }, ends = { hit: [], miss: [] };
    for (const shot of this.run.meta.shots) {
      if (shot.time > time || (!isWhole && this.trail !== String(shot.robot) && shot.end < time - LATELY)) continue;
      const way = this.run.wayOf(shot.piece, shot.time, Math.min(time, shot.end));
      if (!way.length) continue;
      ways[shot.result].push(way);
      if (shot.end <= time && ends[shot.result]) ends[shot.result].push(way.at(-1));
    }
    const looks = { hit: ["hit", []], miss: ["miss", [0.1, 0.06]], pass: ["muted", [0.02, 0.05]], flying: ["muted", [0.03, 0.04]] };
    for (const [result, [stroke, dash]] of /** @type {[string, [string, number[]]][]} */ (Object.entries(looks))) this.paint({ stroke, dash, wide: 0.025, alpha: 0.85 }, () => { for (const way of ways[result]) this.shape(way, false); });
    this.paint({ fill: "hit", stroke: "paper", wide: 0.01 }, () => { for (const [x, y] of ends.hit) { this.pen.moveTo(x + 0.06, y); this.pen.arc(x, y, 0.06, 0, TURN); } });
    const cross = (x, y, marks) => { for (const [u, v] of marks) this.shape([[x - u, y - v], [x + u, y + v]], false); };
    this.paint({ stroke: "miss", wide: 0.03 }, () => { for (const [x, y] of ends.miss) cross(x, y, [[0.07, 0.07], [0.07, -0.07]]); });
    this.paint({ stroke: "path", wide: 0.02 }, () => {
      for (const [at, x, y] of this.run.meta.taken) if (at <= time && (isWhole || at > time - LATELY)) cross(x, y, [[0.05, 0], [0, 0.05]]);
    });
  }

  /** Draw the number of pieces on each level, at the center of the level's places. */
  counts(time) {
    /** @type {Map<string, LevelData[]>} */
    const spots = new Map();
    for (const level of this.run.meta.levels) {
      const spot = level.middle && level.middle.map((at) => Math.round(at)).join();
      if (spot) spots.set(spot, [...spots.get(spot) ?? [], level]);
    }
    for (const mine of spots.values()) {
      const [x, y] = mine[0].middle, tall = 0.24, reach = 0.062 * Math.max(...mine.map(({ label }) => label.length)) + 0.22, top = y + 0.5 * tall * mine.length;
      this.paint({ fill: "paper", stroke: mine[0].alliance || "neutral", wide: 0.015, alpha: 0.9 }, () => this.pen.roundRect(x - reach, top - tall * mine.length - 0.03, 2 * reach, tall * mine.length + 0.06, 0.08));
      mine.forEach(({ name, label }, row) => {
        this.words(x + reach - 0.3, top - tall * (row + 0.5), 0.2, label, { align: "right" });
        this.words(x + reach - 0.16, top - tall * (row + 0.5), 0.2, String(this.run.count(name, time)), { color: "ink", bold: true });
      });
    }
  }

  /** Return the heat maps with their colors, by name: positions of robots, and ends of missed shots. */
  heatMaps() {
    const { run } = this, { meta } = run, driven = [], fallen = [];
    for (const time of run.groups.robots.times.subarray(0, run.groups.robots.n)) {
      meta.robots.forEach((_, k) => { const pose = run.robot(k, time); if (pose) driven.push(pose.place); });
    }
    for (const shot of meta.shots) if (shot.result === "miss") fallen.push(...run.wayOf(shot.piece, shot.time, shot.end).slice(-1));
    /** @type {Record<string, [number[][], string]>} */
    const maps = { robot: [driven, "path"], misses: [fallen, "miss"] };
    return Object.fromEntries(Object.entries(maps).filter(([, [places]]) => places.length)
      .map(([name, [places, color]]) => [name, Object.assign(squares(meta.field.size, places), { color })]));
  }

  /** Show a ring at the position of a score. @param {ArrayLike<number>} place */
  flash(place) { this.flashes.push([place, performance.now()]); }
}
