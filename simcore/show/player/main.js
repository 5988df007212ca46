// Start of the page: show the report or the run that the page contains, or connect to a live run.
import { inflate } from "./data.js";
import { Live } from "./live.js";
import { Player } from "./player.js";
import { showReport } from "./report.js";

async function start() {
  const text = (id) => document.getElementById(id).textContent;
  if (document.getElementById("report")) {
    showReport(document.querySelector("main"), JSON.parse(new TextDecoder().decode(await inflate(text("report")))));
    document.body.dataset.shown = "report";
    return;
  }
  if (!document.getElementById("run")) { window.simcore = new Live(); return; }
  const meta = JSON.parse(new TextDecoder().decode(await inflate(text("run"))));
  const player = window.simcore = new Player(meta, await inflate(text("data")));
  const wanted = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  player.show(location.hash.includes("t=") && Number.isFinite(wanted) ? wanted : meta.failure ? player.run.end : player.run.start);
}
start();
