// Three-dimensional drawing of a robot, labeled with dimensions.
import { make, svg } from "./dom.js";
import { THEMES, drawsInSoftware, shaped, written } from "./solid.js";

const BESIDE = 0.14;  // [m]; distance of dimension lines from the robot

/** Draw a robot in an element, and return the drawing. @param {HTMLElement} home @param {RobotSpec} spec */
export const robotModel = (home, spec) => new RobotModel(home, spec);

/** Return the lower and upper corner of the bounding box of points. @param {Point[]} points @returns {[Point, Point]} */
export function reach(points) {
  const over = (pick) => /** @type {Point} */ ([0, 1, 2].map((axis) => points.reduce((found, point) => pick(found, point[axis]), points[0][axis])));
  return [over(Math.min), over(Math.max)];
}

class RobotModel {
  /** @param {HTMLElement} home @param {RobotSpec} spec */
  constructor(home, { title, solids, bumpers }) {
    const named = new Map(solids.filter(({ name }) => name).map(({ name, color }) => [name, color]));
    this.canvas = make("canvas", { role: "img" });
    home.replaceChildren(make("figcaption", {}, make("strong", {}, title || ""), ...[...named].map(([name, color]) =>
      make("span", {}, svg("svg", { viewBox: "0 0 20 8", "aria-hidden": "true" }, svg("rect", { width: 20, height: 8, fill: color })), ` ${name}`))), this.canvas);
    const isPlain = drawsInSoftware(), theme = THEMES[matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"];
    const scene = this.scene = new THREE.Scene(), sun = new THREE.DirectionalLight(0xfffaf0, 1.2 * theme.sun), paint = (look) => new THREE.MeshLambertMaterial(look);
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: !isPlain, alpha: true });
    this.renderer.setPixelRatio(isPlain ? 1 : Math.min(devicePixelRatio, 2));
    sun.position.set(1.5, -2, 4);
    scene.add(sun, new THREE.HemisphereLight(0xffffff, 0xa4a8b0, 1.25 * theme.light));
    const floor = new THREE.Mesh(new THREE.CircleGeometry(1.4, 48), paint({ color: theme.carpet }));
    floor.position.z = -0.002;
    scene.add(floor);
    for (const { color, opacity, points, faces } of solids) {
      scene.add(new THREE.Mesh(shaped(points.flat(), new THREE.Uint16BufferAttribute(faces.flat(), 1)),
        paint({ color, opacity, transparent: opacity < 1, depthWrite: opacity >= 1, side: opacity < 1 ? THREE.DoubleSide : THREE.FrontSide })));
    }
    const [low, high] = reach(solids.filter(({ name }) => !name).flatMap(({ points }) => points)), [u, v] = bumpers.map((size) => size / 2), x = high[0] + BESIDE, y = low[1] - BESIDE;
    this.measures = [this.measure("bumpers", [-u, y, 0], [u, y, 0]), this.measure("", [x, -v, 0], [x, v, 0]), this.measure("height", [low[0], y, 0], [low[0], y, high[2]])];
    this.canvas.setAttribute("aria-label", `the robot in three dimensions: ${this.measures.join(", ")}; drag to turn, scroll to zoom`);
    this.measure("front", [x + 0.25, -0.06, 0], [x + 0.45, 0, 0], [x + 0.25, 0.06, 0]);
    this.eye = new THREE.PerspectiveCamera(36, 1.9, 0.05, 20);
    this.eye.up.set(0, 0, 1);
    this.eye.position.set(1.6, -1.75, 1.3);
    const control = new THREE.OrbitControls(this.eye, this.canvas);
    control.target.set(0.05, 0, 0.42 * high[2]);
    control.maxPolarAngle = 1.55;
    control.addEventListener("change", () => this.draw());
    control.update();
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.resize();
  }

  /** Draw a line through points with a name, and with the length if the line has two points; return the text. */
  measure(name, ...places) {
    const lines = new THREE.BufferGeometry(), [from, to] = [places[0], places.at(-1)], long = Math.hypot(...from.map((at, k) => to[k] - at));
    lines.setAttribute("position", new THREE.Float32BufferAttribute(places.slice(1).flatMap((place, k) => [...places[k], ...place]), 3));
    const text = places.length === 2 ? `${name} ${long.toFixed(2)} m`.trim() : name, sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: written(text, "transparent", "#ffe08a", 0.55, 6).map, depthTest: false }));
    sprite.scale.set(0.54, 0.09, 1);
    sprite.position.set(...from.map((at, k) => k === 2 ? to[k] + 0.05 : (at + to[k]) / 2));
    this.scene.add(new THREE.LineSegments(lines, new THREE.LineBasicMaterial({ color: 0xffe08a })), sprite);
    return text;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    this.eye.aspect = width / height;
    this.eye.updateProjectionMatrix();
    this.draw();
  }

  draw() { this.renderer.render(this.scene, this.eye); }
}
