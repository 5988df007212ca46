// Time line with periods as bands, shots as ticks by side, other events as marks, and the slider, all on one scale.
import { ticks } from "./charts.js";
import { make } from "./dom.js";
import { ink } from "./top.js";

export const MARKS = { mode: "\u25b6", put: "\u21e9", hit: "\u25cf", miss: "\u2715", pass: "\u2192", flying: "\u25cb", score: "+", slip: "\u2248",
  bump: "\u25b2", brownout: "\u25bc", foul: "\u25c6", placed: "\u25a3" };
const SHOTS = ["hit", "miss", "pass", "flying"], QUIET = ["mode", "score", ...SHOTS];
const BAND = 17, TICKS = 26, GLYPHS = 15, SCALE = 14;  // [px]
const NEAR = 5;  // [px]

export class TimeLine {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run @param {(time: number) => void} go */
  constructor(home, run, go) {
    this.run = run;
    this.slider = home.querySelector("input");
    this.canvas = make("canvas", { "aria-hidden": "true" });
    home.querySelector("canvas")?.remove();
    home.prepend(this.canvas);
    this.slider.oninput = () => go(Number(this.slider.value));
    this.slider.onpointermove = (event) => { this.slider.title = this.markAt(event)?.title ?? ""; };
    this.slider.onclick = (event) => { const mark = this.markAt(event); if (mark) go(mark.time); };
    new ResizeObserver(() => this.draw()).observe(home);
    this.update();
  }

  /** Read the current data of the run. */
  update() {
    const { start, end, meta } = this.run;
    Object.assign(this.slider, { min: start, max: end, step: 0.02 });
    this.shots = meta.shots.map((shot) => ({ ...shot, robot: meta.robots[shot.robot] }));
    const quiet = [...QUIET, ...meta.robots.length > 2 ? ["slip"] : []];  // with many robots, some tire is sliding most of the time
    this.marks = meta.events.filter(([, kind]) => !quiet.includes(kind));
    const texts = meta.events.map(([time, kind, text]) => ({ time, kind, title: `${time.toFixed(2)} s: ${text}` }));
    this.spots = texts.filter(({ kind }) => kind !== "score");
    this.draw();
  }

  x(time) { return 1 + (time - this.run.start) / (this.run.end - this.run.start || 1) * (this.width - 2); }

  /** Return the event at a pointer, or undefined. */
  markAt(event) {
    const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    const inRow = (kind) => kind === "mode" ? y < BAND : SHOTS.includes(kind) ? y >= BAND && y < BAND + TICKS : y >= BAND + TICKS;
    const near = this.spots.filter(({ time, kind }) => inRow(kind) && Math.abs(this.x(time) - x) <= NEAR);
    return near.sort((one, other) => Math.abs(this.x(one.time) - x) - Math.abs(this.x(other.time) - x))[0];
  }

  draw() {
    const { run, canvas } = this, width = this.width = canvas.parentElement.clientWidth, sharp = Math.min(devicePixelRatio, 2), pen = canvas.getContext("2d");
    const rows = [BAND, this.shots.length ? TICKS : 0, this.marks.length ? GLYPHS : 0, SCALE], tall = rows.reduce((sum, row) => sum + row);
    [canvas.width, canvas.height] = [Math.round(width * sharp), Math.round(tall * sharp)];
    canvas.style.height = canvas.parentElement.style.height = `${tall}px`;
    if (!width) return;
    pen.setTransform(sharp, 0, 0, sharp, 0, 0);
    const color = (name) => ink(name), text = (words, x, y, size, name) => { Object.assign(pen, { fillStyle: color(name), font: `${size}px system-ui, sans-serif`, textBaseline: "middle" }); pen.fillText(words, x, y); };
    const { times, values } = run.meta.board.find(({ label }) => label === "period") ?? { times: [run.start], values: [""] };
    times.forEach((from, k) => {
      const until = times[k + 1] ?? run.end, x = this.x(Math.max(from, run.start)), wide = this.x(until) - x, words = values[k] || "";
      pen.fillStyle = color(/disabled/.test(words) || !words ? "soft" : `${this.whose((from + until) / 2)}-fill`);
      pen.fillRect(x, 0, Math.max(0, wide - 1), BAND - 2);
      const shown = words.replace(", disabled", "");
      pen.font = "11px system-ui, sans-serif";
      if (pen.measureText(shown).width < wide - 8) text(shown, x + 5, BAND / 2 - 0.5, 11, /disabled/.test(words) ? "muted" : "ink");
    });
    pen.fillStyle = color("grid");
    if (rows[1]) pen.fillRect(0, BAND + TICKS / 2, width, 1);
    for (const { time, robot, result } of this.shots) {
      const isUp = robot.alliance !== "red" && !(robot.is_run && robot.name !== run.sides[0].label), high = { hit: 11, miss: 5, pass: 3, flying: 7 }[result];
      pen.fillStyle = color(robot.own_ink || robot.alliance || "ink");
      pen.globalAlpha = result === "hit" ? 1 : 0.55;
      pen.fillRect(this.x(time) - 0.75, BAND + TICKS / 2 + (isUp ? -high : 1), 1.5, high);
    }
    pen.globalAlpha = 1;
    pen.textAlign = "center";
    for (const [time, kind] of this.marks) text(MARKS[kind], this.x(time), BAND + rows[1] + GLYPHS / 2, 11, kind === "placed" ? "hit" : kind === "put" ? "ink" : "miss");
    for (const at of ticks(run.start, Math.max(run.end, run.start + 1), Math.max(2, Math.floor(width / 70)))) {
      pen.textAlign = this.x(at) > width - 24 ? "right" : this.x(at) < 12 ? "left" : "center";
      text(`${at} s`, this.x(at), tall - SCALE / 2, 11, "muted");
    }
    pen.textAlign = "left";
  }

  /** Return the only alliance with lit field elements at a time; `neutral` if both or none have lit elements. */
  whose(time) {
    const on = [...new Set(Object.keys(this.run.meta.lamps).filter((name) => !["off", null].includes(this.run.lamp(name, time))).map((name) => name.split("_")[0]))];
    return on.length === 1 ? on[0] : "neutral";
  }
}
