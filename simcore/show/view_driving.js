// The page's drive button. While it is on and the page has the focus, what keys and gamepad do is sent 30 times a second.
(() => {
  const USED = new Set("$KEYS");
  const OFF = "drive";
  const down = new Set();
  let isOn = false;
  let socket = null;
  let opensAt = 0;

  const box = document.createElement("div");
  box.style.cssText = "position:fixed;left:12px;bottom:12px;z-index:1000;max-width:min(60vw,34rem);" +
    "font:14px/1.4 system-ui,sans-serif;display:flex;gap:10px;align-items:center";
  const button = document.createElement("button");
  button.style.cssText = "font:inherit;padding:6px 14px;border:0;border-radius:6px;background:#1e54b7;color:#fff";
  const note = document.createElement("span");
  note.style.cssText = "background:#fffd;color:#222;border-radius:6px;padding:2px 8px";
  note.setAttribute("role", "status");
  box.append(button, note);

  const say = (text) => {
    note.textContent = text;
    note.hidden = text === "";
  };
  const letGo = () => {
    down.clear();
    if (socket !== null) socket.close();
    socket = null;
  };
  const turn = (on) => {
    isOn = on;
    opensAt = 0;
    letGo();
    button.textContent = on ? "stop driving" : OFF;
    button.setAttribute("aria-pressed", String(on));
    say(on ? "$HELP" : "");
  };
  const open = () => {
    opensAt = performance.now() + 500;
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const opened = new WebSocket(`${scheme}://${location.host}/`, ["$SUBPROTOCOL"]);
    opened.onopen = () => { if (socket === opened) say("$HELP"); };
    opened.onclose = (event) => {
      if (socket !== opened) return;
      socket = null;
      say(`not driving: ${event.reason || "the run does not answer"}`);
    };
    socket = opened;
  };
  const isText = (element) => element instanceof Element &&
    element.closest("input, textarea, select, [contenteditable]") !== null;
  const rounded = (value) => Math.round(1000 * Math.max(-1, Math.min(1, value))) / 1000;
  const gamepad = () => {
    const found = navigator.getGamepads ? [...navigator.getGamepads()] : [];
    return found.find((pad) => pad && pad.connected && pad.mapping === "standard");
  };
  const message = () => {
    const pad = gamepad();
    const pressed = { keys: [...down] };
    if (pad === undefined) return pressed;
    const buttons = pad.buttons.slice(0, 8).map((one) => rounded(one.value));
    return { ...pressed, axes: pad.axes.slice(0, 4).map(rounded), buttons };
  };

  button.onclick = () => {
    turn(!isOn);
    button.blur();
  };
  // On window and before all others: the page moves its camera with some of these keys.
  addEventListener("keydown", (event) => {
    const isTyped = event.ctrlKey || event.altKey || event.metaKey || isText(event.target);
    if (!isOn || isTyped || !USED.has(event.code)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    down.add(event.code);
  }, true);
  addEventListener("keyup", (event) => {
    if (!down.delete(event.code)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);
  addEventListener("focusin", (event) => { if (isText(event.target)) down.clear(); }, true);
  addEventListener("blur", (event) => { if (event.target === window) letGo(); });
  addEventListener("pagehide", letGo);
  document.addEventListener("visibilitychange", () => { if (document.hidden) letGo(); });

  setInterval(() => {
    if (!isOn || document.hidden || !document.hasFocus()) {
      if (socket !== null) letGo();
      return;
    }
    if (socket === null && performance.now() >= opensAt) open();
    if (socket !== null && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message()));
  }, 33);

  turn(false);
  document.body.append(box);
})();
