// Pictures and video frames for sharing: the current view with the score board, the title and the time.
import { ink } from "./top.js";

export const SHARED = [1280, 720];  // [px]
const FONT = 'system-ui, "Segoe UI", Roboto, Arial, sans-serif';
const LIT = { purple: "#b04cff" };

/** Draw the view at the size of a shared picture, with score board, title and time. @param {CanvasRenderingContext2D} pen @param {import("./player.js").Player} player */
export function compose(pen, player) {
  const [width, height] = SHARED, { solid, top, run, isPlan } = player, now = player.score.at(player.now);
  Object.assign(pen, { fillStyle: ink("paper"), textBaseline: "middle", textAlign: "center", shadowBlur: 0 });
  pen.fillRect(0, 0, width, height);
  if (!isPlan) {
    const sky = pen.createLinearGradient(0, 0, 0, height);
    solid.theme.sky.forEach((color, k) => sky.addColorStop(k / 2, color));
    pen.fillStyle = sky;
    pen.fillRect(0, 0, width, height);
  }
  pen.drawImage(isPlan ? top.canvas : solid.canvas, 0, 0, width, height);
  const text = (words, x, y, font, color) => { Object.assign(pen, { fillStyle: color, font: `${font} ${FONT}` }); pen.fillText(words, x, y); };
  const [left, ...rest] = now.sides, middle = width / 2, wide = now.clock ? 62 : 4;
  const box = (side, own, x, across) => {
    Object.assign(pen, { shadowColor: LIT[side.lit] ?? "#fff", shadowBlur: side.lit ? 22 : 0, fillStyle: own.side ? { blue: "#1e54b7", red: "#c42828" }[own.side] : ink(own.ink) });
    pen.beginPath();
    pen.roundRect(x, 12, across, 50, 8);
    pen.fill();
    pen.shadowBlur = 0;
    text(side.name ? `${side.name} ${side.text}` : side.text, x + across / 2, 38, "700 32px", "#fff");
  };
  const size = (side) => { pen.font = `700 32px ${FONT}`; return Math.max(84, pen.measureText(side.name ? `${side.name} ${side.text}` : side.text).width + 28); };
  if (now.clock || now.sides.some((side) => side.text)) {
    Object.assign(pen, { fillStyle: "#14171ce0" });
    pen.beginPath();
    pen.roundRect(middle - wide - size(left) - 8, 6, 2 * wide + size(left) + rest.reduce((sum, side) => sum + size(side), 0) + 16, 62, 12);
    pen.fill();
    box(left, run.sides[0], middle - wide - size(left), size(left));
    rest.forEach((side, k) => box(side, run.sides[k + 1], middle + wide, size(side)));
    text(now.clock, middle, 31, "700 34px", "#fff");
    text(now.period, middle, 57, "500 14px", "#d6dbe2");
  }
  pen.fillStyle = "#14171cb8";
  pen.fillRect(0, height - 34, width, 34);
  pen.textAlign = "left";
  text(run.meta.title, 16, height - 17, "600 17px", "#fff");
  pen.textAlign = "right";
  text(`${player.now.toFixed(1)} s \u00b7 simcore`, width - 16, height - 17, "500 15px", "#d6dbe2");
}

/** Offer a file for download. @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
