// Plays the run that is written in this page: moves and shows what is drawn in it, and puts one time cursor in all charts.
(() => {
  "use strict";
  const run = JSON.parse(document.getElementById("run").textContent);
  const frames = run.frames;
  if (!frames.length) return;
  const find = (selector, inside = document) => inside.querySelector(selector);
  const all = (selector, inside = document) => [...inside.querySelectorAll(selector)];
  const slider = find(".bar input"), clock = find(".bar output"), button = find("#play"), speed = find(".bar select");
  const figures = all("figure.chart"), timed = all("[data-t]").map((node) => [Number(node.dataset.t), node]);
  const robots = all("#now .robot"), ghosts = all("#now .ghost"), lying = find("#now .pieces");
  const cells = all("[data-cell]").map((node) => [node, run.cells[node.dataset.cell] || []]);
  const off = find(".board .off"), boards = all(".board li:not(.off) b");

  // Rows of pieces as Python's `Placed` has them: holder, x, y, scale_x, scale_y, angle, in_air.
  const kinds = run.kinds.flatMap((count, kind) => Array(count).fill(kind));
  const uses = kinds.map((kind, row) => {
    const found = document.getElementById("i" + row);
    return found || document.createElementNS("http://www.w3.org/2000/svg", "use");
  });
  const shown = kinds.map(() => "");
  function full(entry) {
    const [row, holder, ...rest] = entry;
    if (holder < 0) return [-1, 0, 0, 100, 100, 0, 0];
    return run.round[kinds[row]] ? [holder, rest[0], rest[1], rest[2], rest[2], 0, rest[3]] : [holder, ...rest];
  }
  const changes = frames.map((frame) => new Map(frame.moved.map((entry) => [entry[0], full(entry)])));

  // The robot from its side: convex bodies [mm], each moved by its part; part 0 is the robot over the floor. Poses are
  // x, y, z and a unit quaternion, and are in the states behind the pieces.
  const parts = kinds.length, told = [], side = run.side || { solids: [], changes: [] };
  function pose([part, ...news]) {
    if (!news.length) return null;
    const six = news.length % 3 ? [...news, 0, 0] : news;
    const [x, y, z, b, a, c] = told[part] = [...(told[part] || []).slice(0, 6 - six.length), ...six];
    const angle = Math.hypot(a, b, c) / 1000 || 1e-9, sine = Math.sin(angle / 2) / angle / 1000;
    return [x, y, z, Math.cos(angle / 2), a * sine, b * sine, c * sine];
  }
  side.changes.forEach((entries, i) => entries.forEach((entry) => changes[i].set(parts + entry[0], pose(entry))));
  const solids = side.solids.map(([part, shape, fill, opacity]) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", "polygon"), flat = side.shapes[shape];
    for (const [name, value] of Object.entries({ fill, "fill-opacity": opacity, "data-part": part })) node.setAttribute(name, value);
    find(".of-robot g").appendChild(node);
    return [part, node, flat.filter((_, k) => k % 3 === 0).map((x, k) => [x, flat[3 * k + 1], flat[3 * k + 2]])];
  });
  const whole = [];  // every 32nd state, so that a jump is cheap
  let state = run.first.map((entry) => entry.slice(1)), at = 0;
  const step = (i) => changes[i].forEach((values, row) => { state[row] = values; });
  frames.forEach((_, i) => {
    step(i);
    if (i % 32 === 0) whole.push(state.slice());
  });
  function goTo(i) {
    if (at > i || i - at > 32) { at = 32 * (i >> 5); state = whole[i >> 5].slice(); }
    while (at < i) step(++at);
  }
  state = whole[0].slice();

  function rowAt(times, time) {
    let low = 0, high = times.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time + 1e-9) low = middle; else high = middle;
    }
    return low;
  }
  const frameTimes = frames.map((frame) => frame.time);

  function placePiece(row, from, to, part) {
    const [holder, x, y, sx, sy, angle, air] = from;
    const use = uses[row], near = to && to[0] === holder && Math.hypot(to[1] - x, to[2] - y) < 120;
    const k = near ? part : 0, goal = near ? to : from;
    const words = holder < 0 ? "" : `translate(${(x + k * (goal[1] - x)).toFixed(1)} ${(y + k * (goal[2] - y)).toFixed(1)}) ` +
      `rotate(${angle}) scale(${(sx + k * (goal[3] - sx)) / 100} ${(sy + k * (goal[4] - sy)) / 100})`;
    const key = holder + words + air;
    if (shown[row] === key) return;
    shown[row] = key;
    const home = holder < 0 ? null : holder ? find(".held", robots[holder - 1]) : lying;
    if (!home) { use.remove(); return; }
    use.setAttribute("href", `#p${kinds[row]}${air ? "a" : ""}`);
    use.setAttribute("transform", words);
    if (use.parentNode !== home) home.appendChild(use);
  }

  function placeRobot(node, pose, next, part) {
    node.setAttribute("visibility", pose ? "visible" : "hidden");
    if (!pose) return null;
    const to = next || pose, turn = Math.atan2(Math.sin(to[2] - pose[2]), Math.cos(to[2] - pose[2]));
    const x = pose[0] + part * (to[0] - pose[0]), y = pose[1] + part * (to[1] - pose[1]), yaw = pose[2] + part * turn;
    const degrees = yaw * 180 / Math.PI, label = find(".label", node);
    node.setAttribute("transform", `translate(${x.toFixed(1)} ${(run.height - y).toFixed(1)}) rotate(${(-degrees).toFixed(1)})`);
    if (label) label.setAttribute("transform", `rotate(${degrees.toFixed(1)})`);
    return [x, y];
  }

  function moved([x, y, z, w, a, b, c], [p, q, r]) {
    const t = [2 * (b * r - c * q), 2 * (c * p - a * r), 2 * (a * q - b * p)];
    return [x + p + w * t[0] + b * t[2] - c * t[1], y + q + w * t[1] + c * t[0] - a * t[2], z + r + w * t[2] + a * t[1] - b * t[0]];
  }
  function between(from, to, share) {
    const sign = from.slice(3).reduce((sum, value, k) => sum + value * to[3 + k], 0) < 0 ? -1 : 1;
    const mean = from.map((value, k) => value + share * ((k > 2 ? sign : 1) * to[k] - value)), size = Math.hypot(...mean.slice(3));
    return mean.map((value, k) => k > 2 ? value / size : value);
  }
  function half(points) {  // of their convex hull
    const found = [];
    for (const point of points) {
      const isInside = ([a, b], [c, d]) => (c - a) * (point[1] - b) <= (d - b) * (point[0] - a);
      while (found.length > 1 && isInside(...found.slice(-2))) found.pop();
      found.push(point);
    }
    return found.slice(0, -1);
  }
  function drawSide(i, j, share) {
    const poses = state.slice(parts).map((from, k) => {
      const to = j > i && changes[j].get(parts + k);
      return from && to ? between(from, to, share) : from;
    });
    if (!poses[0]) return;
    for (const [part, node, corners] of solids) {
      const seen = poses[part] ? corners.map((corner) => moved(poses[0], part ? moved(poses[part], corner) : corner)) : [];
      const flat = seen.map(([x, , z]) => [x, -z]).sort((one, other) => one[0] - other[0] || one[1] - other[1]);
      node.setAttribute("points", [...half(flat), ...half(flat.reverse())].map((xy) => xy.map(Math.round)).join(" "));
    }
    const [x, , z] = moved(poses[0], [1, 0, 0]).map((value, k) => value - poses[0][k]), up = Math.atan2(z, Math.abs(x)) * 180 / Math.PI;
    find(".of-robot span").textContent = [poses[0][2] > 4 && `${(poses[0][2] / 10).toFixed(0)} cm up`,
      Math.abs(up) > 0.5 && `front ${Math.abs(up).toFixed(0)}\u00b0 ${up > 0 ? "up" : "down"}`].filter(Boolean).join(", ");
  }

  function draw(time) {
    const i = rowAt(frameTimes, time), j = Math.min(i + 1, frames.length - 1);
    const frame = frames[i], next = frames[j], span = next.time - frame.time;
    const part = span > 0 ? Math.min(1, Math.max(0, (time - frame.time) / span)) : 0;
    goTo(i);
    uses.forEach((_, row) => placePiece(row, state[row], j > i && changes[j].get(row), part));
    if (run.side) drawSide(i, j, part);
    const apart = frame.robots.map((pose, k) => {
      const truth = placeRobot(robots[k], pose, next.robots[k], part);
      const belief = placeRobot(ghosts[k], frame.ghosts[k], next.ghosts[k], part);
      robots[k].classList.toggle("active", Boolean(frame.active[k]));
      return truth && belief ? Math.hypot(truth[0] - belief[0], truth[1] - belief[1]) / 100 : null;
    });
    const known = apart.filter((value) => value !== null);
    off.hidden = !known.length;
    find("b", off).textContent = known.map((value) => value.toFixed(2)).join(", ") + " m";
    for (const [from, node] of timed) node.classList.toggle("later", from > time + 1e-9);
    const valueAt = (steps) => steps.length ? steps[rowAt(steps.map((one) => one[0]), time)][1] : 0;
    run.board.forEach((steps, k) => { boards[k].textContent = valueAt(steps); });
    for (const [node, steps] of cells) {
      const count = valueAt(steps), number = find(".n", node);
      node.classList.toggle("full", count > 0);
      if (number) number.textContent = count;
    }
  }

  let now = run.start;
  function show(time) {
    now = Math.min(run.end, Math.max(run.start, time));
    slider.value = now;
    slider.setAttribute("aria-valuetext", `${now.toFixed(2)} seconds`);
    clock.textContent = `${now.toFixed(2)} s`;
    draw(now);
    figures.forEach((figure, k) => {
      const cursor = find(".cursor", figure);
      const x = run.plot.left + (now - run.start) / (run.end - run.start || 1) * run.plot.width;
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
      cursor.removeAttribute("visibility");
      all(".value", figure).forEach((label, j) => {
        const curve = run.charts[k][j], value = curve.values[rowAt(curve.times, now)];
        label.textContent = Math.abs(value) >= 100 || Number.isInteger(value) ? value.toFixed(0) : value.toFixed(2);
      });
    });
  }

  function hear(time) {
    if (!run.phases.length) return;
    const [at, words, left] = run.phases[rowAt(run.phases.map((one) => one[0]), time)];
    const enabled = !words.endsWith("disabled");
    matchSounds.see({ period: words, enabled, time: time - run.start, left: left - (time - at) });
  }

  let last = null;
  function play(stamp) {
    if (last === null) return;
    const time = now + (stamp - last) / 1000 * Number(speed.value);
    last = stamp;
    show(time);
    hear(now);
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
  function jump(time) { stop(); show(time); }

  for (const figure of figures) {
    const chart = find("svg:last-child", figure);
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
  slider.addEventListener("input", () => jump(Number(slider.value)));
  button.addEventListener("click", toggle);
  all("[data-to]").forEach((mark) => mark.addEventListener("click", () => jump(Number(mark.dataset.to))));
  all("input[data-heat]").forEach((box) => box.addEventListener("change", () => {
    find(`g[data-heat="${box.dataset.heat}"]`).setAttribute("visibility", box.checked ? "visible" : "hidden");
  }));
  addEventListener("keydown", (event) => {
    const typing = event.target.closest && event.target.closest("select, summary, button, input[type=checkbox]");
    if (typing && (event.key === " " || event.key === "Enter" || event.target.tagName === "SELECT")) return;
    const size = event.shiftKey ? 1 : 0.1;
    const actions = { " ": toggle, ArrowRight: () => jump(now + size), ArrowLeft: () => jump(now - size),
      Home: () => jump(run.start), End: () => jump(run.end) };
    if (!actions[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    actions[event.key]();
  });
  if (run.phases.length) find(".bar").append(matchSounds.button);
  for (const node of all(".bar, .of-robot")) node.hidden = false;
  find(".keys").hidden = false;
  const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  show(location.hash.includes("t=") && Number.isFinite(wanted) ? wanted : run.start);
})();
