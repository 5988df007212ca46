// Live run: the page receives frames and states over one WebSocket, and sends driving input and commands.
import { inflate } from "./data.js";
import { make } from "./dom.js";
import { tableOf } from "./panels.js";
import { Player } from "./player.js";

const BEHIND = 0.012;  // [s]; delay behind the newest frame, because the page interpolates between frames
const PEOPLE = { blue: "UIOP", red: "HJKL" };  // keys of human players' actions
const QUIET = 50;  // [ms]; interval between messages while a driver's input does not change
const find = (selector) => document.querySelector(selector);

export class Live {
  constructor() {
    this.player = null;
    this.head = 0;
    this.down = new Set();
    this.isDriving = false;
    this.sticks = { axes: [0, 0, 0, 0], buttons: new Array(8).fill(0), used: false };
    this.sent = "";
    this.sentAt = 0;
    this.says = find(".says");
    this.say(["waiting for the run"]);
    this.open();
    this.keys();
    requestAnimationFrame((stamp) => this.step(stamp));
  }

  open() {
    const socket = this.socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live`);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => { this.queue = (this.queue || Promise.resolve()).then(() => this.take(event.data)); };
    socket.onclose = (event) => {
      this.say([event.reason || "the run does not answer"]);
      setTimeout(() => this.open(), 1000);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  say(lines) { this.says.replaceChildren(...lines.map((line) => make("div", {}, line))); }

  async take(data) {
    if (data instanceof ArrayBuffer) return this.frame(data);
    const message = JSON.parse(data);
    if (message.type === "run") this.begin(message.meta, await inflate(message.data));
    if (message.type === "state" && this.player) this.state(message);
    if (message.type === "end" && this.player) this.finish(message.meta, await inflate(message.data));
    return undefined;
  }

  frame(buffer) {
    if (!this.player) return;
    this.head = this.player.run.append(buffer);
    this.arrived = performance.now();
    if (this.head < this.player.now - 0.5) this.player.now = this.head;
  }

  begin(meta, bytes) {
    if (this.player) {
      if (meta.run !== this.meta.run) location.reload();  // a new run begins on a newly loaded page, without data of the previous run
      return;
    }
    this.meta = meta;
    const player = this.player = new Player(meta, bytes);
    player.toggle = () => {
      if (this.isOver) return Player.prototype.toggle.call(player);
      if (!player.isFollowing) { player.isFollowing = true; return undefined; }
      return this.send({ do: "pause", value: !this.isPaused });
    };
    player.onSpeed = (speed) => { if (!this.isOver) this.send({ do: "speed", value: speed }); };
    player.button.textContent = "Pause";
    this.buttons();
    this.touch();
    if (meta.drive.robots.length) {
      this.driveButton.hidden = false;
      if (meta.drive.at_once) { this.drive(true); this.countDown(3); }
    }
    player.onScore = () => this.rumble();
    if (player.solid) player.solid.isDriven = Boolean(meta.drive.at_once);
    document.body.classList.add("live");
  }

  /** Pause the run, count down with a sound at each number, and resume the run. */
  countDown(left) {
    this.send({ do: "pause", value: left > 0 });
    find(".count").textContent = left > 0 ? String(left) : "";
    this.player.sounds.play(left > 0 ? "count" : "start");
    if (left > 0) setTimeout(() => this.countDown(left - 1), 700);
  }

  /** The first connected gamepad with the standard mapping, or undefined. */
  get pad() { return (navigator.getGamepads ? [...navigator.getGamepads()] : []).find((one) => one && one.connected && one.mapping === "standard"); }

  /** Make the driver's gamepad rumble after a score. */
  rumble() { if (this.isDriving) this.pad?.vibrationActuator?.playEffect("dual-rumble", { duration: 120, strongMagnitude: 0.6, weakMagnitude: 0.8 }); }

  state({ board, cells, lamps, previews, values, says, time, paused, clock, reached }) {
    const { meta } = this.player.run;
    const note = (changes, value) => {
      if (changes.values.at(-1) !== value) { changes.times.push(time); changes.values.push(value); }
    };
    for (const [label, text] of board) {
      let item = meta.board.find((one) => one.label === label);
      if (!item) meta.board.push(item = { label, times: [], values: [] });
      note(item, text);
    }
    for (const item of meta.board) if (!board.some(([label]) => label === item.label)) note(item, null);
    for (const [name, on] of Object.entries(lamps)) note(meta.lamps[name] ??= { times: [], values: [] }, on);
    for (const [name, count] of Object.entries(cells)) note(meta.cells[name] ??= { times: [], values: [] }, count);
    if (this.player.solid) this.player.solid.previews = previews;
    this.player.charts.append(time, values);
    this.isPaused = paused;
    this.clock = clock;
    this.say([paused ? "paused" : `running at ${reached}`, ...this.isDriving && find(".sticks").hidden ? [this.meta.drive.help] : [], ...says]);
    if (!this.isOver) this.player.button.textContent = !this.player.isFollowing ? "Live" : paused ? "Resume" : "Pause";
    if (clock) this.player.sounds.see(clock);
    this.player.line.update();
  }

  step(stamp) {
    requestAnimationFrame((next) => this.step(next));
    this.sendInput();
    const { player } = this;
    if (!player || !player.isFollowing || this.isOver || !player.run.groups.robots.n) { this.before = stamp; return; }
    if (player.solid && !this.isPaused && this.before) player.solid.keepUp(stamp, stamp - this.before);
    const speed = this.isPaused ? 1 : Number(player.speed.value), dt = Math.min(0.1, (stamp - (this.before ?? stamp)) / 1000) * speed;
    this.before = stamp;
    const goal = this.head - BEHIND * Math.max(1, speed), off = goal - player.now;
    // play at the speed of the run, slightly faster or slower to stay just behind the newest frame
    const time = Math.abs(off) > 0.25 * Math.max(1, speed) ? goal : player.now + Math.max(0, dt * (1 + 6 * (off - dt)));
    player.show(Math.min(this.head, time));
    if (stamp - (this.charted ?? 0) > 500) { this.charted = stamp; player.charts.draw(player.now); }
  }

  // --- the end --------------------------------------------------------------------------------------------------------

  finish(meta, bytes) {
    const { player } = this, { run } = player;
    this.isOver = true;
    if (player.last === null) player.button.textContent = "Play";
    this.drive(false);
    Object.assign(run.meta, { events: meta.events, tables: meta.tables, facts: meta.facts, phases: meta.phases, shots: meta.shots, taken: meta.taken, charts: meta.charts });
    run.bytes = bytes;
    const go = (time) => player.jump(time);
    player.report(go);
    const sheet = find(".sheet");
    sheet.replaceChildren(make("h2", {}, meta.verdict), ...meta.tables.slice(0, 1).map((table) => tableOf(table, go)),
      make("p", {}, make("button", { type: "button", onclick: () => this.again() }, "again (R)"), " ",
        make("button", { type: "button", onclick: () => { sheet.hidden = true; } }, "look at the run")));
    sheet.hidden = false;
    player.show(run.end);
  }

  again() { this.send({ do: "restart", seed: Number(this.seed.value) }); }

  buttons() {
    const { meta } = this, press = (message) => () => this.send(message), robot = () => this.player.solid ? this.player.solid.robot : 0;
    this.seed = make("input", { type: "number", min: "0", step: "1", value: String(meta.seed), "aria-label": "seed" });
    this.driveButton = make("button", { type: "button", "aria-pressed": "false", hidden: true, onclick: () => { this.drive(!this.isDriving); this.driveButton.blur(); } }, "drive");
    const kind = make("select", { "aria-label": "piece" }, ...meta.spawn.map((name) => make("option", {}, name)));
    const button = (label, act) => make("button", { type: "button", onclick: (event) => { act(); event.currentTarget.blur(); } }, label);
    const people = Object.entries(meta.people.length ? PEOPLE : {}).flatMap(([alliance, keys]) => [
      ...meta.people.map(([name, summary], k) => button(`${alliance}: ${summary}${keys[k] ? ` (${keys[k]})` : ""}`, press({ do: "human", alliance, name }))),
      button(`${alliance}: leave it to the game`, press({ do: "leave", alliance }))]);
    find(".field-buttons").replaceChildren(this.driveButton, button("restart with this seed", () => this.again()), this.seed,
      make("details", {}, make("summary", {}, "field"), ...meta.spawn.length > 1 ? [kind] : [],
        button("put a piece in front of the robot", () => this.send({ do: "spawn", kind: kind.value, robot: robot() })),
        button("put all pieces back", press({ do: "reset" })),
        button("put the robot at its start", () => this.send({ do: "start", robot: robot() }))),
      ...people.length ? [make("details", {}, make("summary", {}, "human players"), ...people)] : []);
  }

  // --- driving --------------------------------------------------------------------------------------------------------

  drive(on) {
    if (on === this.isDriving) return;
    this.isDriving = on;
    this.down.clear();
    if (on && navigator.userActivation?.isActive) this.player.sounds.first();
    this.driveButton.textContent = on ? "stop driving" : "drive";
    this.driveButton.setAttribute("aria-pressed", String(on));
    document.body.classList.toggle("driving", on);
    if (!on) this.letGo();
  }

  letGo() {
    this.down.clear();
    this.sent = "";
    this.send({ drive: null });
  }

  keys() {
    const isText = (node) => node instanceof Element && node.closest("input, textarea, select, [contenteditable]") !== null;
    // capturing listeners on the window run first; the page has other uses for some of these keys
    addEventListener("keydown", (event) => {
      if (!this.meta || event.ctrlKey || event.altKey || event.metaKey || isText(event.target)) return;
      if (event.code === "KeyR" && this.isOver) { this.again(); return; }
      if (this.isDriving && this.meta.drive.keys.includes(event.code)) {
        event.preventDefault();
        event.stopImmediatePropagation();
        this.down.add(event.code);
        this.player.sounds.first();
        this.sendInput();
        return;
      }
      for (const [alliance, keys] of event.repeat ? [] : Object.entries(PEOPLE)) {
        const action = this.meta.people[keys.indexOf(event.key.toUpperCase())];
        if (keys.includes(event.key.toUpperCase()) && action) this.send({ do: "human", alliance, name: action[0] });
      }
    }, true);
    addEventListener("keyup", (event) => {
      if (!this.down.delete(event.code)) return;
      event.preventDefault();
      this.sendInput();
    }, true);
    addEventListener("focusin", (event) => { if (isText(event.target)) this.down.clear(); }, true);
    addEventListener("blur", (event) => { if (event.target === window) this.letGo(); });
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.letGo(); });
  }

  /** Send the state of keys, gamepad and on-screen sticks at once after a change, and otherwise twenty times a second. */
  sendInput() {
    if (!this.isDriving || document.hidden || !document.hasFocus() || this.socket.readyState !== WebSocket.OPEN) return;
    const rounded = (value) => Math.round(1000 * Math.max(-1, Math.min(1, value))) / 1000;
    const { pad } = this;
    const input = { robot: this.player && this.player.solid ? this.player.solid.robot : 0, keys: [...this.down] };
    if (pad) Object.assign(input, { axes: [...pad.axes].slice(0, 4).map(rounded), buttons: [...pad.buttons].slice(0, 8).map((one) => rounded(one.value)) });
    else if (this.sticks.used) Object.assign(input, { axes: this.sticks.axes.map(rounded), buttons: this.sticks.buttons });
    const text = JSON.stringify(input), now = performance.now();
    if (text === this.sent && now - this.sentAt < QUIET) return;
    [this.sent, this.sentAt] = [text, now];
    this.send({ drive: input });
  }

  /** Make on-screen sticks and buttons that act like the sticks and buttons of a gamepad. */
  touch() {
    const { sticks } = this, home = find(".sticks");
    const stick = (name, axes) => {
      const knob = make("i"), pad = make("div", { class: "stick", role: "application", "aria-label": name }, knob);
      const move = (event) => {
        const box = pad.getBoundingClientRect(), r = box.width / 2;
        let x = (event.clientX - box.left) / r - 1, y = (event.clientY - box.top) / r - 1;
        const size = Math.max(1, Math.hypot(x, y));
        [x, y] = [x / size, y / size];
        knob.style.transform = `translate(${x * r * 0.6}px, ${y * r * 0.6}px)`;
        sticks.used = true;
        axes.forEach((axis, k) => { if (axis !== null) sticks.axes[axis] = k ? y : x; });
        this.sendInput();
      };
      const end = () => {
        knob.style.transform = "";
        axes.forEach((axis) => { if (axis !== null) sticks.axes[axis] = 0; });
        this.sendInput();
      };
      pad.addEventListener("pointerdown", (event) => { pad.setPointerCapture(event.pointerId); this.drive(true); move(event); });
      pad.addEventListener("pointermove", (event) => { if (pad.hasPointerCapture(event.pointerId)) move(event); });
      for (const kind of ["pointerup", "pointercancel"]) pad.addEventListener(kind, end);
      return pad;
    };
    const held = (label, number) => {
      const set = (value) => () => { sticks.used = true; sticks.buttons[number] = value; this.sendInput(); };
      return make("button", { type: "button", onpointerdown: set(1), onpointerup: set(0), onpointerleave: set(0) }, label);
    };
    home.replaceChildren(stick("drive", [0, 1]), make("div", {}, held("intake", 4), ...this.meta.drive.actions.slice(0, 4).map((name, k) => held(name, k))), stick("turn", [2, null]));
    home.hidden = !(this.meta.drive.robots.length && matchMedia("(pointer: coarse)").matches);
  }
}
