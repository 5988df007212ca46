// Player: shows a run from above and in three dimensions, with panels, playback controls, keys and cameras.
import { Run, rowAt } from "./data.js";
import { make } from "./dom.js";
import { keyOf } from "./key.js";
import { Board, Charts, Places, Score, drawEvents, drawTables } from "./panels.js";
import { SHARED, compose, download } from "./picture.js";
import { CAMERAS, Solid } from "./solid.js";
import { Sounds } from "./sound.js";
import { TimeLine } from "./timeline.js";
import { Top } from "./top.js";

export const VIEWS = ["both", "top", "solid"];
const CLIP = 10;  // [s]
const LATELY = 0.6;  // [s]; longest time between the disappearance of a piece and the points for the piece
const DRAG = 4;  // [px]; a pointer that has moved no farther counts as a click
const find = (selector) => document.querySelector(selector);

export class Player {
  /** @param {Meta} meta @param {Uint8Array} bytes */
  constructor(meta, bytes) {
    this.run = new Run(meta, bytes);
    this.now = this.run.start;
    this.last = null;  // time stamp of the last drawn picture during playback; null while stopped
    this.isLive = Boolean(meta.live);
    this.isFollowing = this.isLive;
    this.sounds = new Sounds();
    this.states = new Int8Array(this.run.pieces.length);
    this.places = new Float32Array(3 * this.run.pieces.length);
    this.gone = [];  // [time, position] of pieces that disappeared in flight
    this.points = {};
    this.rises = [];  // [time, side, points] of scores without a known position
    this.drawnAt = null;
    this.build();
  }

  build() {
    const { meta } = this.run, go = (time) => this.jump(time);
    document.title = meta.title;
    find("h1").textContent = meta.title;
    const notes = meta.notes.map((text) => make("p", { class: "note" }, text));
    find(".notes").replaceChildren(...meta.failure ? [make("p", { class: "failure" }, meta.failure), make("details", {}, make("summary", {}, "what the test says"), ...notes)] : notes);
    this.top = new Top(find(".top"), this.run);
    this.score = new Score(find(".score"), this.run);
    this.board = new Board(find(".board"), this.run);
    try {
      find(".solid canvas")?.remove();
      this.solid = new Solid(find(".solid"), this.run);
      this.solid.onMove = () => { if (this.last === null && !this.isLive) this.drawSolid(); };
    } catch (error) {
      this.solid = null;  // the browser has no WebGL
      find(".solid").replaceChildren(make("p", { class: "note" }, `this browser cannot draw 3D: ${error.message}`));
      find(".views").classList.add("flat");
    }
    this.bar(go);
    this.report(go);
    if (this.solid) this.solid.onCamera = (name) => { this.cameraChoice.value = name; };
    this.pointers();
    this.choose(null);
    this.setView(this.solid ? meta.view || "both" : "top");
    if (this.solid && meta.camera) this.setCamera(meta.camera);
    new ResizeObserver(() => { if (this.size !== this.sizeNow()) this.resize(); }).observe(find(".views"));
    addEventListener("keydown", (event) => this.onKey(event));
  }

  /** Show the report of the whole run. */
  report(go) {
    const { meta } = this.run;
    find(".facts").replaceChildren(...meta.facts.map(([name, value]) => make("li", {}, make("span", {}, name), make("b", {}, value))));
    find(".key").replaceChildren(...keyOf(this.run), ...this.heat());
    this.counts = new Places(find(".places"), this.run);
    this.charts = new Charts(find(".charts-home"), this.run, go);
    drawEvents(find(".events"), this.run, go);
    drawTables(find(".tables"), this.run, go);
    this.line.update();
  }

  bar(go) {
    const { meta } = this.run, choice = (label, options, act) => {
      const select = make("select", { "aria-label": label, title: label, onchange: () => { act(select.value); select.blur(); } },
        ...options.map(([value, text]) => make("option", { value }, text)));
      return select;
    };
    this.line = new TimeLine(find(".line"), this.run, go);
    this.slider = this.line.slider;
    this.clock = make("output");
    this.button = make("button", { type: "button", id: "play", "aria-label": "play or pause (space)", onclick: () => { this.toggle(); this.button.blur(); } }, "Play");
    this.speed = choice("speed", [0.1, 0.25, 0.5, 1, 2, 4].map((value) => [value, `${value}x`]), () => this.onSpeed(Number(this.speed.value)));
    this.speed.value = "1";
    this.viewChoice = choice("view (V)", [["both", "3D, and from above"], ["top", "from above, and 3D"], ["solid", "3D"]], (value) => this.setView(value));
    this.cameraChoice = choice("camera (C)", CAMERAS.map((name) => [name, `camera: ${name}`]), (value) => this.setCamera(value));
    const robots = meta.robots.map(({ label }, k) => [String(k), label.length < 5 ? `robot ${label}` : label]);
    this.robotChoice = choice("robot", [["", "all robots"], ...robots], (value) => this.choose(value === "" ? null : Number(value)));
    this.trailChoice = choice("trails", [["lately", "trails: last 5 s"], ["whole", "trails: all"], ...robots.map(([k, name]) => [k, `trails: ${name}`]), ["none", "no trails"]],
      (value) => { this.top.trail = value; this.draw(); });
    this.trailChoice.value = this.top.trail;
    const tools = [this.button, this.clock, this.speed, ...this.solid ? [this.viewChoice, this.cameraChoice] : [], ...robots.length > 1 ? [this.robotChoice] : [], this.trailChoice];
    if (meta.phases.length || this.isLive) tools.push(this.sounds.button);
    if (this.solid && window.MediaRecorder) tools.push(this.clipButton = make("button", { type: "button", title: "the last 10 s as a video, 1280 x 720", onclick: () => this.clip() }, "Save clip"));
    tools.push(make("button", { type: "button", title: "a PNG of the current view, 1280 x 720", onclick: () => this.savePicture() }, "Save picture"));
    find(".tools").replaceChildren(...tools);
    find(".bar").hidden = false;
  }

  heat() {
    const maps = this.top.heatMaps(), boxes = Object.keys(maps).map((name) => make("input", { type: "checkbox", "data-map": name, onchange: (event) => {
      for (const box of boxes) if (box !== event.target) box.checked = false;
      this.top.heat = event.target.checked ? maps[name] : null;
      this.draw();
    } }));
    this.top.heat = null;
    return boxes.map((box) => make("label", {}, box, ` heat map: ${box.dataset.map}`));
  }

  /** Make clicks select a robot or clear the selection; a click on the small view swaps the views. */
  pointers() {
    let from = [0, 0];
    for (const [name, other] of [["top", "both"], ["solid", "top"]]) {
      const home = find(`.${name}`), isInset = () => getComputedStyle(home).position === "absolute";
      home.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; });
      home.addEventListener("click", (event) => {
        if (Math.hypot(event.clientX - from[0], event.clientY - from[1]) > DRAG) return;
        if (isInset()) this.setView(find(".views").dataset.view === "both" ? "top" : other === "top" ? "both" : "top");
        else if (this.run.meta.robots.length > 1) this.choose(name === "top" ? this.top.robotAt(event, this.now) : this.solid.robotAt(event));
      });
    }
  }

  setView(name) {
    find(".views").dataset.view = name;
    this.viewChoice.value = name;
    this.resize();
  }

  setCamera(name) {
    this.solid.look(name);
    if (find(".views").dataset.view === "top") this.setView("both");
    this.draw();
  }

  /** Select a robot for the pose estimate and the camera. Null clears the selection; a single robot stays selected. @param {number | null} number */
  choose(number) {
    const chosen = number ?? (this.run.meta.robots.length === 1 ? 0 : null);
    this.chosen = this.top.chosen = chosen;
    if (this.solid) this.solid.chosen = chosen;
    if (this.solid && chosen !== null) this.solid.robot = chosen;
    this.robotChoice.value = number === null ? "" : String(number);
    this.draw();
  }

  sizeNow() { return [find(".views").clientWidth, find(".views").clientHeight, find(".views").dataset.view].join(); }

  resize() {
    this.size = this.sizeNow();
    if (this.solid) this.solid.resize();
    this.top.resize();
    this.draw();
  }

  // --- drawing --------------------------------------------------------------------------------------------------------

  drawSolid() { if (this.solid && this.drawnAt !== null) this.solid.draw(this.now); }

  draw() {
    if (this.drawnAt === null) return;  // nothing to draw before the first call of `show`
    const time = this.now;
    if (find(".views").dataset.view !== "solid") this.top.draw(time);
    this.drawSolid();
    this.score.draw(time);
    this.board.draw(time, this.chosen);
    this.counts.draw(time);
    if (!this.isLive || this.last === null) this.charts.draw(time);
    if (this.onPicture) this.onPicture();
  }

  /** Mark scores since the last picture: a flash where a flying piece disappeared, rising points, and a sound. */
  watchScores(time) {
    const isNear = this.drawnAt !== null && time > this.drawnAt && time - this.drawnAt < 0.5;
    this.run.eachPiece(time, (row, x, y, z, state) => {
      if (isNear && this.states[row] === 2 && state === 0) {
        const place = this.places.slice(3 * row, 3 * row + 3);
        this.top.flash(place);
        if (this.solid) this.solid.flash(place);
        this.gone.push([time, place]);
      }
      this.states[row] = state;
      if (state) this.places.set([x, y, z], 3 * row);
    });
    this.gone = this.gone.filter(([when]) => Math.abs(time - when) < LATELY);
    let points = 0;
    for (const { label, side } of this.run.sides) {
      const now = Number(this.run.text(label, time) ?? 0), rise = now - (this.points[label] ?? now);
      this.points[label] = now;
      if (isNear && rise > 0) { points += rise; this.rises.push([time, side, rise]); }
    }
    this.rises = this.rises.filter(([when, side, rise]) => {
      const isLate = time - when > LATELY, place = Math.abs(time - when) > 2 * LATELY ? null : this.placeOfScore(side, time, isLate);
      if (place && this.solid) this.solid.score(`+${rise}`, side, place);
      return !place && !isLate && time >= when;
    });
    this.drawnAt = time;
    if (points) { this.sounds.play("scored"); this.onScore(points); }
  }

  onScore(_points) {}

  /** Return the position for the points of a side: where a piece disappeared in the side's half, or the only robot. */
  placeOfScore(side, time, isLate) {
    const { robots, field } = this.run.meta, mine = robots.map((_, k) => k).filter((k) => !side || robots[k].alliance === side);
    const near = this.gone.filter(([, [x]]) => !side || (x < field.size[0] / 2) === (side === "blue"));
    if (near.length) return near.at(-1)[1];
    const pose = isLate && mine.length === 1 ? this.run.robot(mine[0], time) : null;
    return pose && [pose.place[0], pose.place[1], pose.place[2] + 0.5];
  }

  show(time) {
    this.now = Math.min(this.run.end, Math.max(this.run.start, time));
    this.slider.value = String(this.now);
    this.slider.setAttribute("aria-valuetext", `${this.now.toFixed(2)} seconds`);
    this.clock.textContent = `${this.now.toFixed(2)} s`;
    this.watchScores(this.now);
    this.draw();
  }

  // --- time -----------------------------------------------------------------------------------------------------------

  hear(time) {
    const { phases } = this.run.meta;
    if (!phases.length) return;
    const [at, words, left] = phases[rowAt(phases.map((phase) => phase[0]), time)];
    this.sounds.see({ period: words, enabled: !words.endsWith("disabled"), time: time - this.run.start, left: left - (time - at) });
  }

  step(stamp) {
    if (this.last === null) return;
    const time = this.now + (stamp - this.last) / 1000 * Number(this.speed.value);
    if (this.solid && !this.onStop) this.solid.keepUp(stamp, stamp - this.last);  // clips are recorded at a fixed size
    this.last = stamp;
    this.show(time);
    this.hear(this.now);
    if (this.now >= (this.until ?? this.run.end)) this.stop(); else requestAnimationFrame((next) => this.step(next));
  }

  play() {
    if (this.now >= this.run.end) this.show(this.run.start);
    this.last = performance.now();
    this.button.textContent = "Pause";
    requestAnimationFrame((stamp) => this.step(stamp));
  }

  stop() {
    this.last = null;
    this.until = null;
    if (this.solid) this.solid.sharpen(this.solid.finest);
    this.button.textContent = "Play";
    this.charts.draw(this.now);
    if (this.onStop) this.onStop();
  }

  toggle() { if (this.last !== null) this.stop(); else this.play(); }

  jump(time) {
    if (this.last !== null) this.stop();
    this.isFollowing = false;
    this.show(time);
  }

  onSpeed(_speed) {}

  // --- sharing --------------------------------------------------------------------------------------------------------

  get isPlan() { return !this.solid || this.viewChoice.value === "top"; }

  /** Draw at the size of shared pictures while `act` runs, then at the normal size again. */
  async atSize(act) {
    const [width, height] = SHARED;
    if (this.solid) { this.solid.sharpen(1); this.solid.resize(width, height); }
    this.top.resize(width, height, 1);
    this.draw();
    await act();
    if (this.solid) this.solid.sharpen(this.solid.finest);
    this.resize();
  }

  /** Play the last ten seconds again, record the playback, and save the recording as a video file. */
  clip() {
    const end = Math.max(this.now, Math.min(this.run.end, this.run.start + CLIP)), canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = SHARED;
    const type = ["video/mp4", "video/webm"].find((one) => MediaRecorder.isTypeSupported(one)), pen = canvas.getContext("2d");
    const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: type, videoBitsPerSecond: 6e6 }), parts = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    this.clipButton.textContent = "recording";
    this.jump(end - CLIP);
    return this.atSize(() => new Promise((resolve) => {
      this.onPicture = () => compose(pen, this);
      this.onStop = () => { this.onStop = this.onPicture = null; recorder.stop(); };
      recorder.onstop = () => {
        download(new Blob(parts, { type }), `clip.${type.slice(6)}`);
        this.clipButton.textContent = "Save clip";
        resolve(null);
      };
      recorder.start();
      this.play();
      this.until = end;
    }));
  }

  /** Save the current view as a PNG file. */
  savePicture() {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = SHARED;
    return this.atSize(() => {
      compose(canvas.getContext("2d"), this);
      canvas.toBlob((blob) => download(blob, `run_${this.now.toFixed(2)}s.png`), "image/png");
    });
  }

  nextCamera() {
    if (this.solid) this.setCamera(CAMERAS[(CAMERAS.indexOf(this.solid.camera) + 1) % CAMERAS.length]);
  }

  onKey(event) {
    const on = event.target instanceof Element ? event.target.closest("select, summary, button, input:not([type=range]), a") : null;
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    if (on && (event.key === " " || event.key === "Enter" || on.tagName === "SELECT" || on.tagName === "INPUT")) return;
    const size = event.shiftKey ? 1 : 0.1;
    const actions = { " ": () => this.toggle(), ArrowRight: () => this.jump(this.now + size), ArrowLeft: () => this.jump(this.now - size),
      Home: () => this.jump(this.run.start), End: () => this.jump(this.run.end), c: () => this.nextCamera(),
      v: () => this.solid && this.setView(VIEWS[(VIEWS.indexOf(find(".views").dataset.view) + 1) % VIEWS.length]) };
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }
}
