// The player: one time, drawn from above and in three dimensions, with everything around it; keys, play, speeds, views.
import { Run, rowAt } from "./data.js";
import { make } from "./dom.js";
import { Board, Charts, Places, drawEvents, drawTables } from "./panels.js";
import { download, pictureOf } from "./picture.js";
import { CAMERAS, Solid } from "./solid.js";
import { Sounds } from "./sound.js";
import { keyOf } from "./symbols.js";
import { Top } from "./top.js";

export const VIEWS = ["both", "top", "solid"];
const CLIP = 10;  // [s]
const find = (selector) => document.querySelector(selector);

export class Player {
  /** @param {Meta} meta @param {Uint8Array} bytes */
  constructor(meta, bytes) {
    this.run = new Run(meta, bytes);
    this.now = this.run.start;
    this.last = null;  // stamp of the last picture while it plays
    this.isLive = Boolean(meta.live);
    this.isFollowing = this.isLive;
    this.sounds = new Sounds();
    this.states = new Int8Array(this.run.pieces.length);
    this.places = new Float32Array(3 * this.run.pieces.length);
    this.drawnAt = null;
    this.build();
  }

  build() {
    const { meta } = this.run, go = (time) => this.jump(time);
    document.title = meta.title;
    find("h1").textContent = meta.title;
    find(".notes").replaceChildren(...meta.notes.map((text) => make("p", { class: "note" }, text)));
    find(".facts").replaceChildren(...meta.facts.map(([name, value]) => make("li", {}, make("span", {}, name), make("b", {}, value))));
    find(".key").replaceChildren(...keyOf(this.run));
    this.top = new Top(find(".top"), this.run);
    this.counts = new Places(find(".places"), this.run);
    this.board = new Board(find(".board"), this.run);
    this.charts = new Charts(find(".charts-home"), this.run, go);
    drawEvents(find(".timeline"), find(".events"), this.run, go);
    drawTables(find(".tables"), this.run, go);
    try {
      find(".solid canvas")?.remove();
      this.solid = new Solid(find(".solid"), this.run);
      this.solid.onMove = () => { if (this.last === null && !this.isLive) this.drawSolid(); };
    } catch (error) {
      this.solid = null;  // a browser without WebGL
      find(".solid").replaceChildren(make("p", { class: "note" }, `this browser draws no 3D: ${error.message}`));
    }
    this.bar();
    if (this.solid) this.solid.onCamera = (name) => { this.cameraChoice.value = name; };
    this.heat();
    this.setView(this.solid ? meta.view || "both" : "top");
    if (this.solid && meta.camera) this.setCamera(meta.camera);
    new ResizeObserver(() => this.resize()).observe(find(".views"));
    addEventListener("keydown", (event) => this.onKey(event));
  }

  bar() {
    const { meta } = this.run, choice = (label, options, act) => {
      const select = make("select", { "aria-label": label, title: label, onchange: () => { act(select.value); select.blur(); } },
        ...options.map(([value, text]) => make("option", { value }, text)));
      return select;
    };
    this.slider = find(".bar input");
    this.clock = find(".bar output");
    this.button = find("#play");
    this.slider.oninput = () => this.jump(Number(this.slider.value));
    this.button.onclick = () => { this.toggle(); this.button.blur(); };
    this.speed = choice("speed", [0.1, 0.25, 0.5, 1, 2, 4].map((value) => [value, `${value}x`]), () => this.onSpeed(Number(this.speed.value)));
    this.speed.value = "1";
    this.viewChoice = choice("view", [["both", "both views"], ["top", "from above"], ["solid", "3D"]], (value) => this.setView(value));
    this.cameraChoice = choice("camera (C)", CAMERAS.map((name) => [name, `camera: ${name}`]), (value) => this.setCamera(value));
    const robots = meta.robots.map((robot, k) => [String(k), robot.name || `robot ${k}`]);
    this.robotChoice = choice("robot of the camera", robots, (value) => this.setRobot(Number(value)));
    this.trailChoice = choice("trails", [["lately", "trails: last 5 s"], ["whole", "trails: all"], ...robots.map(([k, name]) => [k, `trails: ${name}`]), ["none", "no trails"]],
      (value) => { this.top.trail = value; this.draw(); });
    this.trailChoice.value = this.top.trail;
    const tools = [this.speed, ...this.solid ? [this.viewChoice, this.cameraChoice] : [], ...robots.length > 1 && this.solid ? [this.robotChoice] : [], this.trailChoice];
    if (meta.phases.length || this.isLive) tools.push(this.sounds.button);
    if (this.solid && window.MediaRecorder) tools.push(this.clipButton = make("button", { type: "button", onclick: () => this.clip() }, "clip"));
    tools.push(make("button", { type: "button", onclick: () => this.savePicture() }, "Save picture"));
    find(".tools").replaceChildren(...tools);
    find(".bar").hidden = false;
    this.range();
  }

  range() {
    this.slider.min = this.run.start;
    this.slider.max = this.run.end;
    this.slider.step = 0.02;
  }

  heat() {
    const boxes = Object.entries(this.top.heatMaps()).map(([name, layer]) => {
      layer.setAttribute("visibility", "hidden");
      this.top.layers.heat.append(layer);
      const box = make("input", { type: "checkbox", onchange: () => layer.setAttribute("visibility", box.checked ? "visible" : "hidden") });
      return make("label", {}, box, ` heat map: ${name}`);
    });
    find(".key").append(...boxes);
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

  setRobot(number) {
    this.solid.robot = number;
    this.robotChoice.value = String(number);
    this.draw();
  }

  resize() {
    if (this.solid) this.solid.resize();
    this.draw();
  }

  // --- drawing --------------------------------------------------------------------------------------------------------

  drawSolid() {
    if (this.solid && find(".views").dataset.view !== "top") this.solid.draw(this.now);
  }

  draw() {
    const time = this.now;
    if (this.isLive || find(".views").dataset.view !== "solid") this.top.draw(time);
    this.drawSolid();
    this.board.draw(time);
    this.counts.draw(time);
    if (!this.isLive || this.last === null) this.charts.draw(time);
  }

  /** Flash and sound for what was in the air when it was last looked at, and is nowhere now. */
  watchScores(time) {
    const isNear = this.drawnAt !== null && time > this.drawnAt && time - this.drawnAt < 0.5;
    let scored = 0;
    this.run.eachPiece(time, (row, x, y, z, state) => {
      if (isNear && this.states[row] === 2 && state === 0) {
        const place = this.places.slice(3 * row, 3 * row + 3);
        this.top.flash(place);
        if (this.solid) this.solid.flash(place);
        scored++;
      }
      this.states[row] = state;
      if (state) this.places.set([x, y, z], 3 * row);
    });
    this.drawnAt = time;
    if (scored) this.sounds.play("scored");
  }

  show(time) {
    this.now = Math.min(this.run.end, Math.max(this.run.start, time));
    this.slider.value = this.now;
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
    if (this.solid && !this.onStop) this.solid.keepUp(stamp, stamp - this.last);  // a clip keeps its size
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

  /** The last ten seconds as a video file, recorded while they are played once more. */
  clip() {
    const end = Math.max(this.now, Math.min(this.run.end, this.run.start + CLIP));
    const type = ["video/mp4", "video/webm"].find((one) => MediaRecorder.isTypeSupported(one));
    const recorder = new MediaRecorder(this.solid.canvas.captureStream(30), { mimeType: type }), parts = [];
    recorder.ondataavailable = (event) => parts.push(event.data);
    recorder.onstop = () => {
      download(new Blob(parts, { type }), `clip.${type.slice(6)}`);
      this.clipButton.textContent = "clip";
    };
    this.clipButton.textContent = "recording";
    this.jump(end - CLIP);
    this.onStop = () => { this.onStop = null; recorder.stop(); };
    recorder.start();
    this.play();
    this.until = end;
  }

  /** What is seen now as a PNG file. */
  async savePicture() {
    const canvas = await pictureOf(this);
    canvas.toBlob((blob) => download(blob, `run_${this.now.toFixed(2)}s.png`), "image/png");
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
