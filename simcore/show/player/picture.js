// A picture of the run as it is seen now: title and score board over the 3D view, or over the field from above.
const WIDTH = 1600, EDGE = 24;  // [px]
const FONT = 'system-ui, "Segoe UI", Roboto, Arial, sans-serif';

/** Colors of the page's theme by name. */
const colorOf = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** An SVG of the page as an image; it has no style sheet of its own, so rules and colors go with it. @param {SVGElement} drawing */
async function imageOf(drawing, width, height) {
  const copy = /** @type {SVGElement} */ (drawing.cloneNode(true));
  copy.setAttribute("width", width);
  copy.setAttribute("height", height);
  copy.setAttribute("font-family", FONT);
  const style = document.createElementNS("http://www.w3.org/2000/svg", "style");
  style.textContent = document.querySelector("style").textContent;
  copy.prepend(style);
  const text = new XMLSerializer().serializeToString(copy).replace(/var\(--([\w-]+)\)/g, (_, name) => colorOf(name));
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
  await image.decode();
  return image;
}

/** Draw the board's labels and texts in lines as wide as the picture; returns its height. Without a canvas it is only measured. */
function drawBoard(context, items, top, isDrawn) {
  let x = EDGE, y = top;
  for (const { label, text } of items) {
    context.font = `600 24px ${FONT}`;
    let wide = context.measureText(text).width;
    context.font = `16px ${FONT}`;
    wide = Math.max(wide, context.measureText(label).width);
    if (x > EDGE && x + wide > WIDTH - EDGE) { x = EDGE; y += 62; }
    if (isDrawn) {
      context.fillStyle = colorOf("muted");
      context.fillText(label, x, y + 16);
      context.font = `600 24px ${FONT}`;
      context.fillStyle = colorOf(["blue", "red"].includes(label) ? label : "ink");
      context.fillText(text, x, y + 44);
    }
    x += wide + 30;
  }
  return items.length ? y + 62 - top : 0;
}

/** The picture as a canvas. @param {import("./player.js").Player} player */
export async function pictureOf(player) {
  const { solid, top, board, run } = player, isSolid = solid && player.viewChoice.value !== "top";
  const { width, height } = isSolid ? { width: solid.canvas.clientWidth, height: solid.canvas.clientHeight } : top.drawing.viewBox.baseVal;
  const tall = Math.round(WIDTH * height / width), canvas = document.createElement("canvas"), context = canvas.getContext("2d");
  const items = [{ label: "time", text: `${player.now.toFixed(2)} s` }, ...[...board.nodes].map(([label, { text }]) => ({ label, text }))]
    .filter(({ text }) => text && !text.startsWith("led:"));
  const head = 64, low = head + drawBoard(context, items, head, false);
  canvas.width = WIDTH;
  canvas.height = low + tall;
  context.fillStyle = colorOf("paper");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = colorOf("ink");
  context.font = `700 30px ${FONT}`;
  context.fillText(run.meta.title, EDGE, 44, WIDTH - 2 * EDGE);
  drawBoard(context, items, head, true);
  if (isSolid) {
    const before = solid.renderer.getPixelRatio();
    solid.sharpen(WIDTH / width);
    solid.draw(player.now);
    context.drawImage(solid.canvas, 0, low, WIDTH, tall);
    solid.sharpen(before);
    solid.draw(player.now);
  } else context.drawImage(await imageOf(top.drawing, WIDTH, tall), 0, low);
  return canvas;
}

/** Hand a file to the reader. @param {Blob} blob @param {string} name */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
