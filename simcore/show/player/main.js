// Starts the page: a run that is written in it, or one that comes over a socket.
import { inflate } from "./data.js";
import { Live } from "./live.js";
import { Player } from "./player.js";

async function start() {
  const text = (id) => document.getElementById(id).textContent;
  if (!document.getElementById("run")) { window.simcore = new Live(); return; }
  const meta = JSON.parse(new TextDecoder().decode(await inflate(text("run"))));
  const player = window.simcore = new Player(meta, await inflate(text("data")));
  const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  player.show(location.hash.includes("t=") && Number.isFinite(wanted) ? wanted : player.run.start);
}
start();
