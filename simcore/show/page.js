// Plays the run that is written in this page: robots and pieces on the field, and one time cursor in all charts.
(() => {
  "use strict";
  const run = JSON.parse(document.getElementById("run").textContent);
  const frames = run.frames;
  if (!frames.length) return;
  const svg = document.querySelector(".field svg");
  const [left, top, width, height] = svg.getAttribute("viewBox").split(" ").map(Number);
  const canvas = document.querySelector(".field canvas");
  const pen = canvas.getContext("2d");
  const bar = document.querySelector(".bar");
  const slider = bar.querySelector("input");
  const clock = bar.querySelector("output");
  const button = bar.querySelector("button");
  const speed = bar.querySelector("select");
  const figures = [...document.querySelectorAll("figure")];

  // Frames tell what changed; every 32nd is kept whole, so that a jump is cheap.
  const whole = [];
  let held = { at: -1, pieces: new Map() };
  function step(pieces, frame) {
    for (const place of frame.gone) {
      const count = pieces.get(place) - 1;
      if (count > 0) pieces.set(place, count); else pieces.delete(place);
    }
    for (const place of frame.come) pieces.set(place, (pieces.get(place) || 0) + 1);
  }
  {
    const pieces = new Map();
    frames.forEach((frame, i) => {
      step(pieces, frame);
      if (i % 32 === 0) whole.push(new Map(pieces));
    });
  }
  function piecesAt(i) {
    if (held.at > i || i - held.at > 32) held = { at: 32 * (i >> 5), pieces: new Map(whole[i >> 5]) };
    while (held.at < i) step(held.pieces, frames[++held.at]);
    return held.pieces;
  }

  function frameAt(time) {
    let low = 0, high = frames.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (frames[middle].time <= time + 1e-9) low = middle; else high = middle;
    }
    return low;
  }

  function draw(time) {
    const scale = canvas.width / width;
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.setTransform(scale, 0, 0, scale, -left * scale, -top * scale);
    const i = frameAt(time);
    const frame = frames[i], next = frames[Math.min(i + 1, frames.length - 1)];
    const part = next.time > frame.time ? Math.min(1, Math.max(0, (time - frame.time) / (next.time - frame.time))) : 0;
    pen.lineWidth = 1.2;
    for (const place of piecesAt(i).keys()) {
      // see _piece_codes in page.py
      const z = place % 16, y = Math.floor(place / 16) % 2048 - 500, x = Math.floor(place / 32768) % 65536 - 500;
      const high = Math.floor(place / 2147483648), look = run.pieces[high % 16], larger = 1 + 0.06 * z;
      pen.beginPath();
      if (look.isRound) {
        pen.arc(x, run.width - y, look.reach * larger, 0, 2 * Math.PI);
      } else {
        const outline = Math.floor(high / 16), unit = 2 * look.reach * larger / 63;
        const length = Math.floor(outline / 4096) * unit, width = Math.floor(outline / 64) % 64 * unit;
        pen.save();
        pen.translate(x, run.width - y);
        pen.rotate(-(outline % 64) * Math.PI / 64);
        pen.rect(-length / 2, -width / 2, length, width);
        pen.restore();
      }
      pen.fillStyle = z > 2 ? look.air : look.color;
      pen.strokeStyle = look.edge;
      pen.fill();
      pen.stroke();
    }
    frame.robots.forEach((pose, k) => {
      if (!pose) return;
      const to = next.robots[k] || pose, look = run.robots[k];
      const turn = Math.atan2(Math.sin(to[2] - pose[2]), Math.cos(to[2] - pose[2]));
      const x = pose[0] + part * (to[0] - pose[0]), y = pose[1] + part * (to[1] - pose[1]);
      pen.save();
      pen.translate(x, run.width - y);
      pen.rotate(-(pose[2] + part * turn));
      pen.lineWidth = 5;
      pen.fillStyle = "rgba(255,255,255,.75)";
      pen.strokeStyle = look.color;
      pen.beginPath();
      pen.rect(-look.length / 2, -look.width / 2, look.length, look.width);
      pen.fill();
      pen.stroke();
      pen.fillStyle = look.color;  // an arrow to the front
      pen.beginPath();
      pen.moveTo(0.42 * look.length, 0);
      pen.lineTo(0.05 * look.length, 0.3 * look.width);
      pen.lineTo(0.05 * look.length, -0.3 * look.width);
      pen.fill();
      if (run.robots.length > 1) {
        pen.translate(-0.2 * look.length, 0);
        pen.rotate(pose[2] + part * turn);  // upright, whatever the robot does
        pen.font = "bold 30px system-ui, sans-serif";
        pen.textAlign = "center";
        pen.textBaseline = "middle";
        pen.fillText(k, 0, 0);
      }
      pen.restore();
    });
  }

  function valueAt(curve, time) {
    let low = 0, high = curve.times.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (curve.times[middle] <= time + 1e-9) low = middle; else high = middle;
    }
    return curve.values[low];
  }

  let now = run.end;
  function show(time) {
    now = Math.min(run.end, Math.max(run.start, time));
    slider.value = now;
    clock.textContent = `${now.toFixed(2)} s`;
    draw(now);
    figures.forEach((figure, k) => {
      const cursor = figure.querySelector(".cursor");
      const x = run.plot.left + (now - run.start) / (run.end - run.start || 1) * run.plot.width;
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
      cursor.removeAttribute("visibility");
      figure.querySelectorAll(".value").forEach((label, j) => {
        const value = valueAt(run.charts[k][j], now);
        label.textContent = Math.abs(value) >= 100 || Number.isInteger(value) ? value.toFixed(0) : value.toFixed(2);
      });
    });
  }

  let last = null;
  function play(stamp) {
    if (last === null) return;
    const time = now + (stamp - last) / 1000 * Number(speed.value);
    last = stamp;
    show(time);
    if (now >= run.end) stop(); else requestAnimationFrame(play);
  }
  function stop() {
    last = null;
    button.textContent = "Play";
  }
  function toggle() {
    if (last !== null) return stop();
    if (now >= run.end) show(run.start);
    last = performance.now();
    button.textContent = "Pause";
    requestAnimationFrame(play);
  }

  function resize() {
    const box = svg.getBoundingClientRect();
    canvas.width = Math.round(box.width * devicePixelRatio);
    canvas.height = Math.round(box.width * devicePixelRatio * height / width);
    draw(now);
  }
  for (const figure of figures) {
    const chart = figure.querySelector("svg");
    chart.addEventListener("pointermove", (event) => {
      if (last !== null) return;
      const box = chart.getBoundingClientRect();
      const x = (event.clientX - box.left) / box.width * run.plot.total;
      show(run.start + (x - run.plot.left) / run.plot.width * (run.end - run.start));
    });
  }
  slider.min = run.start;
  slider.max = run.end;
  slider.step = 0.02;
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  button.addEventListener("click", toggle);
  addEventListener("resize", resize);
  addEventListener("keydown", (event) => {
    if (event.target !== document.body) return;
    if (event.key === " ") { event.preventDefault(); toggle(); }
    if (event.key === "ArrowRight") show(now + 0.1);
    if (event.key === "ArrowLeft") show(now - 0.1);
  });
  bar.hidden = false;
  svg.querySelector(".end").remove();  // the canvas shows pieces and robots from here on
  const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  resize();
  show(location.hash.includes("t=") && Number.isFinite(wanted) ? wanted : run.end);
})();
