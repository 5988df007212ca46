// The run in three dimensions, by three.js: field, robots with their parts, pieces, and a camera that one key moves on.
import { turned, unpack, yawOf } from "./data.js";

export const CAMERAS = ["free", "station", "follow", "behind", "above"];
const LATELY = 1.2;  // [s] for which the way of a flying piece is seen
const LATE = 40, EARLY = 19, COARSEST = 0.5;  // [ms] between pictures that are too few and enough; least share of pixels
const PREVIEW = 0xeb3ce6, SIGHT = 0x14c88c, TRAIL = 0xff7814;

export class Solid {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.run = run;
    this.home = home;
    this.camera = "free";
    this.robot = 0;
    this.previews = [];
    this.flashes = [];
    this.isPlain = drawsInSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.isPlain });
    this.finest = this.isPlain ? 1 : Math.min(devicePixelRatio, 2);
    this.renderer.setPixelRatio(this.finest);
    this.pace = 1000 / 60;  // [ms] between pictures, a mean
    this.judgedAt = 0;
    this.renderer.shadowMap.enabled = !this.isPlain;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "the field in three dimensions; drag to turn, wheel to come nearer");
    home.prepend(this.canvas);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(matchMedia("(prefers-color-scheme: dark)").matches ? 0x2b3440 : 0xcfdbe8);
    this.eye = new THREE.PerspectiveCamera(45, 2, 0.05, 120);
    this.eye.up.set(0, 0, 1);
    this.control = new THREE.OrbitControls(this.eye, this.canvas);
    this.control.maxPolarAngle = 1.55;
    this.control.addEventListener("start", () => { if (!["free", "follow"].includes(this.camera)) this.look("free", true); });
    this.control.addEventListener("change", () => this.onMove());
    this.onMove = () => {};
    this.onCamera = (/** @type {string} */ _name) => {};
    this.build();
    this.look("free");
  }

  build() {
    const { meta } = this.run, [length, width] = meta.field.size;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x96969b, 1.7));
    const sun = this.sun = new THREE.DirectionalLight(0xfffaf0, 2.1);
    sun.position.set(length / 2 - 3, -4, 14);
    sun.target.position.set(length / 2, width / 2, 0);
    sun.castShadow = !this.isPlain;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -length / 2 - 1, right: length / 2 + 1, top: 8, bottom: -8, near: 2, far: 32 });
    sun.shadow.bias = -4e-4;
    sun.shadow.normalBias = 0.03;
    this.scene.add(sun, sun.target);
    this.lamps = {};
    for (const solid of meta.field.solids) {
      const mesh = this.mesh(solid);
      if (solid.name) (this.lamps[solid.name] ??= []).push(mesh.material);
      this.scene.add(mesh);
    }
    if (!meta.field.solids.length) this.plainField();
    this.tags();
    this.robots = meta.robots.map((robot, number) => {
      const group = new THREE.Group(), parts = [];
      const model = meta.models[robot.model];
      for (const solid of model.body) group.add(this.mesh(solid, robot));
      for (const solids of model.parts) {
        const part = new THREE.Group();
        for (const solid of solids) part.add(this.mesh(solid, robot));
        parts.push(part);
        group.add(part);
      }
      this.number(group, robot, number);
      this.scene.add(group);
      return { group, parts };
    });
    this.kinds = meta.kinds.map((kind) => {
      const geometries = kind.round ? [[new THREE.SphereGeometry(kind.radius, ...this.isPlain ? [9, 6] : kind.count > 100 ? [16, 12] : [28, 20]), kind.color, 1]] :
        kind.solids.length ? kind.solids.map((solid) => [this.geometry(solid), solid.color, solid.opacity]) :
        [[new THREE.BoxGeometry(...kind.size), kind.color, 1]];
      return geometries.map(([geometry, color, opacity]) => {
        const material = new THREE.MeshStandardMaterial({ color, roughness: 0.75, opacity, transparent: opacity < 1 });
        const meshes = new THREE.InstancedMesh(geometry, material, Math.max(1, kind.count));
        meshes.castShadow = meshes.receiveShadow = true;
        meshes.frustumCulled = false;
        this.scene.add(meshes);
        return meshes;
      });
    });
    this.index = meta.kinds.map(() => 0);
    this.order = this.run.pieces.map(({ kind }) => this.index[kind]++);
    this.strokes = Object.fromEntries([["trails", TRAIL], ["sight", SIGHT], ["previews", PREVIEW]].map(([name, color]) => {
      const lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color }));
      lines.frustumCulled = false;
      this.scene.add(lines);
      return [name, lines];
    }));
    this.matrix = new THREE.Matrix4();
    this.whole = new THREE.Matrix4();
    this.hidden = new THREE.Matrix4().makeScale(0, 0, 0);
    this.one = new THREE.Vector3(1, 1, 1);
    this.place = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.belief = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0x7a1254 }));
    this.scene.add(this.belief);
  }

  /** @param {SolidData} solid */
  geometry({ vertices, faces, scale }) {
    const points = unpack(this.run.bytes, vertices), corners = unpack(this.run.bytes, faces), found = new THREE.BufferGeometry();
    found.setAttribute("position", new THREE.Float32BufferAttribute(Float32Array.from(points, (value) => value * scale), 3));
    found.setIndex(new THREE.BufferAttribute(new Uint16Array(corners.buffer), 1));
    found.computeVertexNormals();
    return found;
  }

  /** @param {SolidData} solid @param {RobotData | null} robot */
  mesh(solid, robot = null) {
    const color = robot && solid.name === "bumper" ? robot.bumper : solid.color;
    const material = new THREE.MeshStandardMaterial({ color, roughness: 0.75, opacity: solid.opacity, transparent: solid.opacity < 1, depthWrite: solid.opacity >= 1 });
    if (solid.opacity < 1) material.side = THREE.DoubleSide;
    const found = new THREE.Mesh(this.geometry(solid), material);
    found.castShadow = solid.opacity >= 1;
    found.receiveShadow = true;
    return found;
  }

  /** Carpet, and every element of the field as a low block, for a game without a model of its field. */
  plainField() {
    const { size: [length, width], outlines } = this.run.meta.field;
    const block = (corners, low, high, color) => {
      const n = corners.length, points = [];
      for (let k = 1; k + 1 < n; k++) for (const c of [0, k, k + 1]) points.push(...corners[c], high);
      corners.forEach((corner, k) => {
        const next = corners[(k + 1) % n];
        points.push(...corner, low, ...next, low, ...next, high, ...corner, low, ...next, high, ...corner, high);
      });
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
      geometry.computeVertexNormals();
      const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color, roughness: 0.8, side: THREE.DoubleSide }));
      mesh.receiveShadow = true;
      mesh.castShadow = high > 0;
      this.scene.add(mesh);
    };
    block([[-0.5, -0.5], [length + 0.5, -0.5], [length + 0.5, width + 0.5], [-0.5, width + 0.5]], -0.03, -0.002, "#5c6168");
    for (const [, , color, corners] of outlines) block(corners, 0, 0.3, color);
  }

  /** A plate with its number for each AprilTag. */
  tags() {
    const { tags, tag_size: size } = this.run.meta.field;
    for (const [id, x, y, z, w, a, b, c] of tags) {
      const plate = new THREE.Mesh(new THREE.PlaneGeometry(1.3 * size, 1.3 * size), written(String(id), "#fff", "#111", 0.62));
      plate.material.side = THREE.FrontSide;
      plate.geometry.rotateX(Math.PI / 2);
      plate.geometry.rotateZ(Math.PI / 2);
      plate.quaternion.set(a, b, c, w);
      plate.position.set(x, y, z);
      plate.translateX(0.012);
      this.scene.add(plate);
    }
  }

  /** The robot's number on its bumpers. */
  number(group, robot, number) {
    const [length, width] = robot.size, [low, high] = robot.heights, tall = 0.8 * (high - low), text = robot.name || String(number);
    const material = written(text, "transparent", "#fff", 0.8, text.length > 2 ? 4 : 2);
    for (const [x, y, turn] of [[0, 1, Math.PI], [0, -1, 0], [1, 0, Math.PI / 2], [-1, 0, -Math.PI / 2]]) {
      const plate = new THREE.Mesh(new THREE.PlaneGeometry(tall * (text.length > 2 ? 4 : 2), tall), material);
      plate.geometry.rotateX(Math.PI / 2);
      plate.geometry.rotateZ(turn);
      plate.position.set(x * (length / 2 + 0.006), y * (width / 2 + 0.006), (low + high) / 2);
      group.add(plate);
    }
  }

  // --- what moves -----------------------------------------------------------------------------------------------------

  draw(time) {
    const { run } = this;
    this.robots.forEach(({ group, parts }, k) => {
      const pose = run.robot(k, time);
      group.visible = Boolean(pose);
      if (!pose) return;
      group.position.set(...pose.place);
      group.quaternion.set(...pose.quat);
      group.updateMatrix();
      parts.forEach((part, q) => {
        const at = run.part(k, q, time);
        part.visible = Boolean(at);
        if (at) { part.position.set(...at.place); part.quaternion.set(...at.quat); }
      });
    });
    this.drawPieces(time);
    this.drawTrails(time);
    this.drawBeliefs(time);
    this.stroke("sight", run.lines(time).flat(2));
    this.stroke("previews", this.previews);
    for (const [name, materials] of Object.entries(this.lamps)) {
      const isOn = run.lampIsOn(name, time);
      for (const material of materials) {
        material.emissive.copy(material.color);
        material.emissiveIntensity = isOn ? 0.9 : 0;
      }
    }
    this.moveCamera(time);
    this.fade();
    this.renderer.render(this.scene, this.eye);
  }

  drawPieces(time) {
    const { run } = this;
    run.eachPiece(time, (row, x, y, z, state, rows, a, b, k) => {
      const kind = run.pieces[row].kind, look = run.meta.kinds[kind];
      let matrix = this.hidden;
      if (state) {
        if (look.round) this.turn.identity(); else this.turn.set(...turned(rows, a, b, k));
        matrix = this.matrix.compose(this.place.set(x, y, z), this.turn, this.one);
        if (state > 2 && this.robots[state - 3]) matrix = this.whole.multiplyMatrices(this.robots[state - 3].group.matrix, matrix);
      }
      for (const meshes of this.kinds[kind]) meshes.setMatrixAt(this.order[row], matrix);
    });
    for (const meshes of this.kinds.flat()) meshes.instanceMatrix.needsUpdate = true;
  }

  drawTrails(time) {
    const { rows, times, width, n } = this.run.groups.pieces, points = [];
    const last = n ? this.run.groups.pieces.at(time).a / width : -1;
    for (let i = last; i > 0 && times[i - 1] > time - LATELY; i--) {
      for (const { column } of this.run.pieces) {
        const a = (i - 1) * width + column, b = i * width + column;
        if (rows[a + 3] === 2 && rows[b + 3] === 2 && Math.abs(rows[b] - rows[a]) + Math.abs(rows[b + 1] - rows[a + 1]) < 1500) {
          for (const c of [a, b]) points.push(rows[c] / 1000, rows[c + 1] / 1000, rows[c + 2] / 1000);
        }
      }
    }
    this.stroke("trails", points);
  }

  /** A frame on the carpet where a robot believes to be. */
  drawBeliefs(time) {
    const points = [];
    this.run.meta.robots.forEach(({ size: [length, width] }, k) => {
      const pose = this.run.robot(k, time);
      if (!pose || !pose.belief) return;
      const [x, y, yaw] = pose.belief, cos = Math.cos(yaw), sin = Math.sin(yaw);
      const corner = (u, v) => [x + cos * u - sin * v, y + sin * u + cos * v, 0.02];
      const [a, b, c, d, tip] = [[length / 2, width / 2], [length / 2, -width / 2], [-length / 2, -width / 2], [-length / 2, width / 2], [length / 2 + 0.15, 0]].map(([u, v]) => corner(u, v));
      for (const one of [a, b, b, c, c, d, d, a, a, tip, tip, b]) points.push(...one);
    });
    replace(this.belief, points);
  }

  stroke(name, points) { replace(this.strokes[name], points); }

  /** A light where something has scored. */
  flash(place) {
    const ring = new THREE.Mesh(new THREE.SphereGeometry(0.12, 16, 12), new THREE.MeshBasicMaterial({ color: 0xfff2a8, transparent: true }));
    ring.position.set(...place);
    this.scene.add(ring);
    this.flashes.push([ring, performance.now()]);
  }

  fade() {
    const now = performance.now();
    this.flashes = this.flashes.filter(([ring, since]) => {
      const share = (now - since) / 600;
      ring.scale.setScalar(1 + 3 * share);
      ring.material.opacity = Math.max(0, 1 - share);
      if (share < 1) return true;
      this.scene.remove(ring);
      return false;
    });
  }

  // --- camera ---------------------------------------------------------------------------------------------------------

  /** Take one of `CAMERAS`; `stays`: from where the camera is. */
  look(name, stays = false) {
    this.camera = name;
    const [length, width] = this.run.meta.field.size;
    if (name === "free" && !stays) {
      this.eye.position.set(length / 2, -0.62 * length, 0.62 * length);
      this.control.target.set(length / 2, 0.46 * width, 0);
      this.fit();
    }
    if (name === "follow") this.kept = null;
    this.control.enabled = name !== "above";
    this.eye.fov = name === "station" ? 62 : 45;
    if (name !== "free") this.eye.clearViewOffset();
    this.eye.updateProjectionMatrix();
    this.control.update();
    this.onCamera(name);
  }

  /** As near as the whole field can be seen, in the middle of the window, also of a narrow one. */
  fit() {
    const [length, width] = this.run.meta.field.size, { eye, control } = this;
    const away = eye.position.clone().sub(control.target).normalize();
    const corners = [0, length].flatMap((x) => [0, width].flatMap((y) => [0, 1.8].map((z) => new THREE.Vector3(x, y, z))));
    eye.clearViewOffset();
    let low = 0, high = 0;
    for (let far = 6; far < 80; far *= 1.02) {
      eye.position.copy(away).multiplyScalar(far).add(control.target);
      eye.lookAt(control.target);
      eye.updateMatrixWorld();
      const seen = corners.map((corner) => corner.clone().project(eye));
      [low, high] = [Math.min(...seen.map(({ y }) => y)), Math.max(...seen.map(({ y }) => y))];
      if (seen.every(({ x, z }) => Math.abs(x) < 0.97 && z < 1) && high - low < 1.9) break;
    }
    const wide = 1000 * eye.aspect;
    eye.setViewOffset(wide, 1000, 0, -250 * (high + low), wide, 1000);
  }

  moveCamera(time) {
    const pose = this.run.robot(this.robot, time), [length, width] = this.run.meta.field.size, { eye, control } = this;
    this.eye.up.set(0, 0, 1);
    const robot = this.run.meta.robots[this.robot], side = robot && robot.alliance === "red" ? -1 : 1;
    if (this.camera === "station") {
      const [x, y] = this.run.meta.field.stations[this.robot % 3 + (side < 0 ? 3 : 0)];
      eye.position.set(x + side * 0.05, y, 1.57);  // eyes of standing adults, at the glass
      eye.lookAt(x + side * 6.5, 0.35 * y + 0.65 * width / 2, 0.2);
      control.target.set(x + side * 6.5, 0.35 * y + 0.65 * width / 2, 0.2);
    } else if (this.camera === "above") {
      const tall = Math.max(width / 2, length / 2 / eye.aspect) / Math.tan(eye.fov * Math.PI / 360) * 1.06;
      eye.up.set(0, 1, 0);
      eye.position.set(length / 2, width / 2, tall);
      eye.lookAt(length / 2, width / 2, 0);
      control.target.set(length / 2, width / 2, 0);
    } else if (pose && this.camera === "behind") {
      const yaw = yawOf(pose.quat), [x, y, z] = pose.place;
      eye.position.set(x - 2.6 * Math.cos(yaw), y - 2.6 * Math.sin(yaw), z + 1.6);
      eye.lookAt(x + 1.5 * Math.cos(yaw), y + 1.5 * Math.sin(yaw), z + 0.3);
      control.target.set(x, y, z);
    } else if (pose && this.camera === "follow") {
      const target = new THREE.Vector3(...pose.place);
      if (this.kept === null) {
        control.target.copy(target);
        eye.position.copy(target).add(new THREE.Vector3(-4.2 * side, 0, 3));
      } else eye.position.add(target).sub(control.target);
      control.target.copy(target);
      this.kept = target;
      eye.lookAt(target);
    } else eye.lookAt(control.target);
  }

  /** Draws fewer pixels while pictures come too late, and more when there is time again.
   * @param {number} stamp of this picture [ms] @param {number} since the one before [ms] */
  keepUp(stamp, since) {
    this.pace += 0.15 * (Math.min(since, 1000) - this.pace);
    if (stamp - this.judgedAt < 400) return;
    this.judgedAt = stamp;
    const ratio = this.renderer.getPixelRatio(), wanted = this.pace > LATE ? 0.75 * ratio : this.pace < EARLY ? 1.15 * ratio : ratio;
    this.sharpen(Math.min(this.finest, Math.max(COARSEST * this.finest, wanted)));
  }

  /** Takes so many pixels for one of the screen. @param {number} ratio */
  sharpen(ratio) { if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio); }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.home;
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    const before = this.eye.aspect;
    this.eye.aspect = width / height;
    this.eye.updateProjectionMatrix();
    if (this.camera === "free" && Math.abs(before - this.eye.aspect) > 0.01) this.fit();
  }
}

/** Whether there is no graphics card: shadows, smooth edges and fine balls would take most of the time. */
function drawsInSoftware() {
  const context = document.createElement("canvas").getContext("webgl2"), info = context && context.getExtension("WEBGL_debug_renderer_info");
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  if (context) context.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

function replace(lines, points) {
  if (!points.length && !lines.visible) return;
  lines.visible = points.length > 0;
  if (!lines.visible) return;
  lines.geometry.dispose();
  lines.geometry = new THREE.BufferGeometry();
  lines.geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
}

/** A material with a text in its middle. */
function written(text, paper, ink, size, wide = 1) {
  const canvas = document.createElement("canvas"), tall = 96;
  [canvas.width, canvas.height] = [tall * wide, tall];
  const pen = canvas.getContext("2d");
  if (paper !== "transparent") { pen.fillStyle = paper; pen.fillRect(0, 0, canvas.width, tall); }
  if (paper !== "transparent") { pen.fillStyle = ink; pen.fillRect(8, 8, tall - 16, tall - 16); ink = "#fff"; }
  pen.fillStyle = ink;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.font = `bold ${size * tall}px system-ui, sans-serif`;
  if (paper === "transparent") {  // also seen on white plates
    Object.assign(pen, { strokeStyle: "#14171c", lineWidth: 9, lineJoin: "round" });
    pen.strokeText(text, canvas.width / 2, tall / 2 + 4, canvas.width - 8);
  }
  pen.fillText(text, canvas.width / 2, tall / 2 + 4, canvas.width - 8);
  const texture = new THREE.CanvasTexture(canvas);
  texture.anisotropy = 4;
  return new THREE.MeshBasicMaterial({ map: texture, transparent: true, side: THREE.DoubleSide });
}
