// Report: shows the blocks of text, tables and drawings that simcore/show/report.py makes.
import { chart } from "./charts.js";
import { make, svg } from "./dom.js";
import { robotModel } from "./robot_model.js";

const LONG = 40;  // [characters]; longer cells may wrap
const DRAWINGS = { chart, robot: robotModel, share };

/** Make a table with numbers aligned to the right. @param {{ columns: string[], rows: (string | number | boolean | null)[][], caption: string }} block */
function table({ columns, rows, caption }) {
  const isNumeric = columns.map((_, k) => rows.some((row) => typeof row[k] === "number") && rows.every((row) => row[k] === null || typeof row[k] === "number"));
  const text = (value) => value === null ? "" : typeof value === "number" ? String(Number(value.toPrecision(6))) : String(value);
  /** @type {(k: number, value?: any) => object} */
  const look = (k, value = "") => ({ class: isNumeric[k] ? "number" : text(value).length > LONG ? "long" : null });
  const heads = columns.map((name, k) => make("th", { scope: "col", ...look(k) }, name));
  const lines = rows.map((row) => make("tr", {}, ...row.map((value, k) => make(k ? "td" : "th", { ...k ? {} : { scope: "row" }, ...look(k, value) }, text(value)))));
  return make("div", { class: "wide", tabindex: "0" }, make("table", {}, caption ? make("caption", {}, caption) : "", make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...lines)));
}

/** Draw a bar for a fraction, with the interval of the fraction and a text. @param {HTMLElement} home @param {{ value: number, low: number, high: number, text: string }} block */
function share(home, { value, low, high, text }) {
  const rect = (x, width, y, height, fill) => svg("rect", { x: 100 * x, y, width: 100 * width, height, fill });
  home.replaceChildren(make("figcaption", {}, text), svg("svg", { viewBox: "0 0 100 10", preserveAspectRatio: "none", role: "img", "aria-label": text },
    rect(0, 1, 0, 10, "var(--grid)"), rect(0, value, 0, 10, "var(--hit)"), rect(low, high - low, 3.5, 3, "var(--ink)"), rect(low, 0.003, 1.5, 7, "var(--ink)"), rect(high - 0.003, 0.003, 1.5, 7, "var(--ink)")));
}

/** @param {HTMLElement} home @param {ReportBlock[]} blocks */
export function showReport(home, blocks) {
  let charts = null;  // successive charts are placed side by side
  for (const block of blocks) {
    if (block.kind === "chart") {
      if (!charts) home.append(charts = make("div", { class: "charts" }));
    } else charts = null;
    if (block.kind in DRAWINGS) {
      const figure = make("figure", { class: block.kind });
      (charts ?? home).append(figure);
      DRAWINGS[block.kind](figure, block);
    } else if (block.kind === "headline") home.append(make("h2", {}, block.text), ...block.detail ? [make("p", { class: "note" }, block.detail)] : []);
    else if (block.kind === "paragraph") home.append(make("p", {}, block.text));
    else if (block.kind === "table") home.append(table(/** @type {any} */ (block)));
  }
}
