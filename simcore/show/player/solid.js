// View of a run in three dimensions, drawn with three.js: field, robots with moving parts, pieces, and several cameras.
import { turned, unpack, yawOf } from "./data.js";

export const CAMERAS = ["free", "station", "follow", "behind", "above"];
const LATELY = 1.2;  // [s]; length of the trail of a flying piece
const LATE = 40, EARLY = 19, COARSEST = 0.5;  // time between pictures that is too slow and fast enough [ms]; smallest fraction of the full pixel ratio
const PREVIEW = 0xeb3ce6, SIGHT = 0x14c88c, TRAIL = 0xff9a3d, GHOST = 0xd81b8c;
const SIDES = { blue: 0x3d8bff, red: 0xff3b30, purple: 0xb04cff };
const FRAME = /^#(9ea5ae|70767f)$/;  // frame colors, which are replaced to distinguish the robots of a match
export const THEMES = { light: { sky: ["#7f9dbd", "#cfdce9", "#e6edf4"], haze: 0xd6e0ea, hall: 0xaab4be, sun: 2.1, light: 1.75, carpet: "#565c66" },
  dark: { sky: ["#0a0e15", "#182230", "#232f3e"], haze: 0x1a232e, hall: 0x1c232c, sun: 1.9, light: 1.35, carpet: "#464c56" } };

export class Solid {
  /** @param {HTMLElement} home @param {import("./data.js").Run} run */
  constructor(home, run) {
    this.run = run;
    this.home = home;
    this.camera = "free";
    this.robot = 0;
    this.chosen = null;
    this.isDriven = false;  // with field-relative sticks, the camera of a driver looks away from the driver station
    this.previews = [];
    this.flashes = [];
    this.isPlain = drawsInSoftware();
    this.theme = THEMES[matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"];
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.isPlain, alpha: true });  // the page draws the sky
    this.finest = this.isPlain ? 1 : Math.min(devicePixelRatio, 2);
    this.renderer.setPixelRatio(this.finest);
    this.pace = 1000 / 60;  // [ms]; mean time between pictures
    this.judgedAt = 0;
    this.renderer.shadowMap.enabled = !this.isPlain;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", "the field in three dimensions; drag to turn, scroll to zoom");
    home.prepend(this.canvas);
    this.scene = new THREE.Scene();
    this.eye = new THREE.PerspectiveCamera(45, 2, 0.1, 120);
    this.eye.up.set(0, 0, 1);
    this.control = new THREE.OrbitControls(this.eye, this.canvas);
    this.control.maxPolarAngle = 1.55;
    this.control.addEventListener("start", () => { if (["follow", "free"].includes(this.camera)) this.isHeld = true; else this.look("free", true); });
    this.control.addEventListener("change", () => this.onMove());
    this.onMove = () => {};
    this.onCamera = (/** @type {string} */ _name) => {};
    this.build();
    this.look("free");
  }

  build() {
    const { meta } = this.run, [length, width] = meta.field.size;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x7d828c, this.theme.light));
    const sun = this.sun = new THREE.DirectionalLight(0xfffaf0, this.theme.sun);
    sun.position.set(length / 2 - 3, -4, 14);
    sun.target.position.set(length / 2, width / 2, 0);
    sun.castShadow = !this.isPlain;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -length / 2 - 1, right: length / 2 + 1, top: 8, bottom: -8, near: 2, far: 32 });
    sun.shadow.bias = -4e-4;
    sun.shadow.normalBias = 0.03;
    this.scene.add(sun, sun.target);
    this.soot = drawn(64, 64, (pen) => radial(pen, 64, [[0, "#000b"], [0.45, "#0008"], [1, "#0000"]]));
    this.light = drawn(128, 128, (pen) => radial(pen, 128, [[0, "#fff"], [0.3, "#fff6"], [0.65, "#fff2"], [1, "#fff0"]]));
    this.cut = { uTo: { value: new THREE.Vector3() }, uCut: { value: 0 } };
    this.hall();
    this.lamps = {};
    for (const solid of meta.field.solids) {
      const mesh = this.mesh(solid);
      mesh.geometry.computeBoundingBox();
      if (mesh.geometry.boundingBox.max.z < 0) continue;  // skip carpets
      this.fadeable(mesh.material);
      if (solid.name) (this.lamps[solid.name] ??= []).push(mesh);
      this.scene.add(mesh);
    }
    this.glows = Object.fromEntries(Object.entries(this.lamps).map(([name, meshes]) => [name, this.glow(meshes)]));
    this.tags();
    this.robots = meta.robots.map((robot) => {
      const group = new THREE.Group(), parts = [];
      const model = meta.models[robot.model];
      for (const solid of model.body) group.add(this.mesh(solid, robot));
      for (const solids of model.parts) {
        const part = new THREE.Group();
        for (const solid of solids) part.add(this.mesh(solid, robot));
        parts.push(part);
        group.add(part);
      }
      this.number(group, robot);
      group.add(this.stain(1.35 * robot.size[0], 1.35 * robot.size[1]));
      this.scene.add(group);
      return { group, parts };
    });
    this.kinds = meta.kinds.map((kind) => {
      const geometries = kind.round ? [[new THREE.SphereGeometry(kind.radius, ...this.isPlain ? [kind.count > 100 ? 7 : 14, kind.count > 100 ? 5 : 10] : kind.count > 100 ? [16, 12] : [28, 20]), kind.color, 1]] :
        kind.solids.map((solid) => [this.geometry(solid), solid.color, solid.opacity]);
      return geometries.map(([geometry, color, opacity]) => this.instances(geometry, this.paint({ color, opacity, transparent: opacity < 1 }), kind.count));
    });
    const shade = new THREE.PlaneGeometry(1, 1);
    this.shades = this.isPlain ? meta.kinds.map((kind) => this.instances(shade, this.stainPaint(), kind.count)) : [];
    this.index = meta.kinds.map(() => 0);
    this.order = this.run.pieces.map(({ kind }) => this.index[kind]++);
    this.strokes = Object.fromEntries([["trails", TRAIL], ["sight", SIGHT], ["previews", PREVIEW], ["belief", GHOST]].map(([name, color]) => {
      const lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color }));
      lines.frustumCulled = false;
      this.scene.add(lines);
      return [name, lines];
    }));
    this.ring = new THREE.Mesh(new THREE.RingGeometry(0.66, 0.74, 40), new THREE.MeshBasicMaterial({ color: 0xffffff, transparent: true, opacity: 0.8, depthWrite: false }));
    this.scene.add(this.ring);
    this.matrix = new THREE.Matrix4();
    this.whole = new THREE.Matrix4();
    this.hidden = new THREE.Matrix4().makeScale(0, 0, 0);
    this.one = new THREE.Vector3(1, 1, 1);
    this.size = new THREE.Vector3();
    this.place = new THREE.Vector3();
    this.turn = new THREE.Quaternion();
    this.level = new THREE.Quaternion();
  }

  /** Make a matte material, or a faster material for software rendering. */
  paint(look) { return this.isPlain ? new THREE.MeshLambertMaterial({ fog: false, ...look }) : new THREE.MeshStandardMaterial({ roughness: 0.75, ...look }); }

  instances(geometry, material, count) {
    const meshes = new THREE.InstancedMesh(geometry, material, Math.max(1, count));
    meshes.castShadow = meshes.receiveShadow = true;
    meshes.frustumCulled = false;
    this.scene.add(meshes);
    return meshes;
  }

  /** @param {SolidData} solid */
  geometry(solid) { return geometryOf(this.run.bytes, solid); }

  /** @param {SolidData} solid @param {RobotData | null} robot */
  mesh(solid, robot = null) {
    const color = robot && solid.name === "bumper" ? robot.bumper : robot && robot.frame && FRAME.test(solid.color) ? robot.frame : solid.color;
    const material = this.paint({ color, opacity: solid.opacity, transparent: solid.opacity < 1, depthWrite: solid.opacity >= 1 });
    if (solid.opacity < 1) material.side = THREE.DoubleSide;
    const found = new THREE.Mesh(this.geometry(solid), material);
    found.castShadow = solid.opacity >= 1;
    found.receiveShadow = true;
    return found;
  }

  /** Make a material transparent where it hides the robot that the camera follows. */
  fadeable(material) {
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.cut);
      shader.vertexShader = shader.vertexShader.replace("void main() {", "varying vec3 vAt;\nvoid main() {")
        .replace("#include <project_vertex>", "#include <project_vertex>\nvAt = (modelMatrix * vec4(transformed, 1.0)).xyz;");
      shader.fragmentShader = shader.fragmentShader.replace("void main() {", `varying vec3 vAt; uniform vec3 uTo; uniform float uCut;
void main() {
  if (uCut > 0.0 && vAt.z > 0.3) {
    vec3 way = uTo - cameraPosition; float t = dot(vAt - cameraPosition, way) / dot(way, way);
    if (t < 0.92 && distance(vAt, cameraPosition + t * way) < 0.35 + 0.65 * t && mod(floor(gl_FragCoord.x), 3.0) + mod(floor(gl_FragCoord.y), 3.0) > 0.5) discard;
  }`);
    };
  }

  /** Build the surroundings: sky, a floor that fades into haze, and the carpet with grain, seams and soft shadows of the elements. */
  hall() {
    const { size: [length, width], outlines } = this.run.meta.field, { theme } = this, middle = [length / 2, width / 2];
    this.home.style.background = `linear-gradient(${theme.sky.join()})`;
    this.scene.fog = new THREE.Fog(theme.haze, 24, 48);
    // large flat surfaces; software rendering draws these without lighting
    const flat = (look) => this.isPlain ? new THREE.MeshBasicMaterial(look) : this.paint(look);
    const floor = new THREE.Mesh(new THREE.CircleGeometry(48, 40), flat({ color: theme.hall }));
    floor.position.set(...middle, -0.05);
    floor.receiveShadow = true;
    const dots = this.isPlain ? 40 : 64, carpet = drawn(dots * Math.ceil(length), dots * Math.ceil(width), (pen) => {
      const { width: w, height: h } = pen.canvas, s = w / length;
      pen.fillStyle = theme.carpet;
      pen.fillRect(0, 0, w, h);
      pen.fillStyle = pen.createPattern(grain(), "repeat");
      pen.fillRect(0, 0, w, h);
      pen.setTransform(s, 0, 0, -h / width, 0, h);
      pen.fillStyle = "#0004";
      for (let x = 1.83; x < length; x += 1.83) pen.fillRect(x, 0, 0.02, width);  // seams of carpet six feet wide
      Object.assign(pen, { shadowColor: "#000a", shadowBlur: 0.35 * s, fillStyle: "#0006" });
      for (const [, , corners] of outlines) {
        pen.beginPath();
        for (const [x, y] of corners) pen.lineTo(x, y);
        pen.fill();
      }
    });
    if (!this.isPlain) carpet.anisotropy = 8;
    const cloth = new THREE.Mesh(new THREE.PlaneGeometry(length, width), flat({ map: carpet, fog: false }));
    [cloth.renderOrder, floor.renderOrder] = [1, 2];  // drawn last, only where nothing covers them
    cloth.position.set(...middle, -0.0005);
    cloth.receiveShadow = true;
    this.scene.add(floor, cloth);
  }

  stainPaint() { return new THREE.MeshBasicMaterial({ map: this.soot, transparent: true, depthWrite: false, fog: false }); }

  /** Make a soft shadow on the carpet. */
  stain(length, width) {
    const found = new THREE.Mesh(new THREE.PlaneGeometry(length, width), this.stainPaint());
    found.position.z = 0.006;
    return found;
  }

  /** Make the halo of a lit element, above the element and on the surrounding carpet. */
  glow(meshes) {
    const box = new THREE.Box3(), size = new THREE.Vector3(), middle = new THREE.Vector3();
    for (const mesh of meshes) box.expandByObject(mesh);
    box.getCenter(middle);
    box.getSize(size);
    const look = { map: this.light, transparent: true, depthWrite: false, blending: THREE.AdditiveBlending, fog: false };
    const halo = new THREE.Sprite(new THREE.SpriteMaterial({ ...look, opacity: 0.6 }));
    halo.position.set(middle.x, middle.y, Math.min(middle.z + 0.5, 2));
    halo.scale.setScalar(2.6 * Math.max(size.x, size.y));
    const pool = new THREE.Mesh(new THREE.PlaneGeometry(size.x + 4, size.y + 4), new THREE.MeshBasicMaterial({ ...look, opacity: 0.5 }));
    pool.position.set(middle.x, middle.y, 0.008);
    this.scene.add(halo, pool);
    return [halo, pool];
  }

  /** Make a plate with the number of each AprilTag. */
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
      this.fadeable(plate.material);
      this.scene.add(plate);
    }
  }

  /** Add the label of a robot to the bumpers. */
  number(group, { size: [length, width], heights: [low, high], label, open }) {
    const tall = 0.92 * (high - low), wide = label.length > 2 ? 4 : 2, material = written(label, "transparent", "#fff", 0.8, wide);
    for (const [x, y, turn] of [[0, 1, Math.PI], [0, -1, 0], [1, 0, Math.PI / 2], ...open ? [] : [[-1, 0, -Math.PI / 2]]]) {
      const plate = new THREE.Mesh(new THREE.PlaneGeometry(tall * wide, tall), material);
      plate.geometry.rotateX(Math.PI / 2);
      plate.geometry.rotateZ(turn);
      plate.position.set(x * (length / 2 + 0.008), y * (width / 2 + 0.008), (low + high) / 2);
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
    this.drawChosen(time);
    this.stroke("sight", run.lines(time).flat(2));
    this.stroke("previews", this.previews);
    for (const [name, meshes] of Object.entries(this.lamps)) this.shine(name, meshes, run.lamp(name, time), time);
    this.moveCamera(time);
    this.fade();
    this.renderer.render(this.scene, this.eye);
  }

  /** Show the state of a lit field element: on, off, pulsing or purple. */
  shine(name, meshes, state, time) {
    const isOn = state && state !== "off" && (state !== "pulsing" || time * 3 % 1 < 0.6);
    for (const { material } of meshes) {
      material.emissive.copy(material.color);
      material.emissiveIntensity = isOn ? 0.75 : 0;
    }
    for (const one of this.glows[name]) {
      one.visible = Boolean(isOn);
      one.material.color.setHex(SIDES[state] ?? SIDES[name.split("_")[0]] ?? 0xffffff);
    }
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
      if (!this.isPlain) return;
      const wide = state && state < 3 ? 2 * look.radius * (1.15 + 0.6 * z) : 0;  // the shadow of a higher piece is larger
      this.shades[kind].setMatrixAt(this.order[row], wide ? this.matrix.compose(this.place.set(x, y, 0.004), this.level, this.size.set(wide, wide, 1)) : this.hidden);
    });
    for (const meshes of [...this.kinds.flat(), ...this.shades]) meshes.instanceMatrix.needsUpdate = true;
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

  /** Draw a ring around the selected robot of several, and an outline on the carpet at the robot's estimated pose. */
  drawChosen(time) {
    const { robots } = this.run.meta, points = [], pose = this.chosen === null ? null : this.run.robot(this.chosen, time);
    this.ring.visible = Boolean(pose) && robots.length > 1;
    if (this.ring.visible) this.ring.position.set(pose.place[0], pose.place[1], pose.place[2] + 0.012);
    if (pose && pose.belief) {
      const [length, width] = robots[this.chosen].size, [x, y, yaw] = pose.belief, cos = Math.cos(yaw), sin = Math.sin(yaw);
      const corner = (u, v) => [x + cos * u - sin * v, y + sin * u + cos * v, 0.02];
      const [a, b, c, d, tip] = [[length / 2, width / 2], [length / 2, -width / 2], [-length / 2, -width / 2], [-length / 2, width / 2], [length / 2 + 0.15, 0]].map(([u, v]) => corner(u, v));
      for (const one of [a, b, b, c, c, d, d, a, a, tip, tip, b]) points.push(...one);
    }
    this.stroke("belief", points);
  }

  stroke(name, points) { replace(this.strokes[name], points); }

  /** Show a flash at the position of a score. */
  flash(place) { this.rise(new THREE.Mesh(new THREE.SphereGeometry(0.12, 12, 8), new THREE.MeshBasicMaterial({ color: 0xfff2a8, transparent: true })), place, 600, 0, 3); }

  /** Show points that rise from the position of a score. @param {string} text @param {string} side @param {ArrayLike<number>} place */
  score(text, side, place) {
    const material = new THREE.SpriteMaterial({ map: written(text, "transparent", side === "red" ? "#ff8a80" : side === "blue" ? "#8ab4ff" : "#fff", 0.8, 2).map, depthTest: false, fog: false });
    const sprite = new THREE.Sprite(material);
    sprite.scale.set(1.5, 0.75, 1);
    this.rise(sprite, [place[0], place[1], place[2] + 0.4], 1300, 1.3, 0);
  }

  rise(node, [x, y, z], lasts, up, grows) {
    node.position.set(x, y, z);
    this.scene.add(node);
    this.flashes.push({ node, since: performance.now(), z, lasts, up, grows });
  }

  fade() {
    const now = performance.now();
    this.flashes = this.flashes.filter(({ node, since, z, lasts, up, grows }) => {
      const share = (now - since) / lasts;
      if (grows) node.scale.setScalar(1 + grows * share);
      node.position.z = z + up * share;
      node.material.opacity = Math.max(0, 1 - share * share);
      if (share < 1) return true;
      this.scene.remove(node);
      return false;
    });
  }

  /** Return the number of the robot at a pointer, or null. */
  robotAt(event) {
    const box = this.canvas.getBoundingClientRect(), at = new THREE.Vector3();
    const far = this.robots.map(({ group }) => {
      at.copy(group.position).project(this.eye);
      return group.visible && at.z < 1 ? Math.hypot((at.x + 1) / 2 * box.width + box.left - event.clientX, (1 - at.y) / 2 * box.height + box.top - event.clientY) : Infinity;
    });
    const nearest = far.indexOf(Math.min(...far)), reach = nearest < 0 ? 0 : Math.max(24, 0.6 * box.height / this.eye.position.distanceTo(this.robots[nearest].group.position));
    return nearest >= 0 && far[nearest] < reach ? nearest : null;
  }

  // --- camera ---------------------------------------------------------------------------------------------------------

  /** Switch to one of `CAMERAS`; keep the position of the camera if `stays` is true. */
  look(name, stays = false) {
    this.camera = name;
    const [length, width] = this.run.meta.field.size;
    if (name === "free" && !stays) {
      const down = (56 + 28 * Math.min(0.6, Math.max(0, 2.25 - this.eye.aspect))) * Math.PI / 180;  // steeper in a narrower picture
      this.eye.position.set(length / 2, 0.46 * width - Math.cos(down), Math.sin(down));
      this.control.target.set(length / 2, 0.46 * width, 0);
      this.fit();
    }
    this.kept = null;
    this.isHeld = stays;
    this.seenAt = null;
    this.control.enabled = name !== "above";
    this.eye.fov = name === "station" ? 62 : 45;
    if (name !== "free") this.eye.clearViewOffset();
    this.eye.updateProjectionMatrix();
    this.control.update();
    this.onCamera(name);
  }

  /** Move the camera as close as possible to the field with the whole field in view, and center the field. */
  fit() {
    const [length, width] = this.run.meta.field.size, { eye, control } = this;
    const away = eye.position.clone().sub(control.target).normalize();
    const corners = [0, length].flatMap((x) => [0, width].flatMap((y) => [0, 1.2].map((z) => new THREE.Vector3(x, y, z))));
    eye.clearViewOffset();
    let low = 0, high = 0;
    for (let far = 6; far < 80; far *= 1.02) {
      eye.position.copy(away).multiplyScalar(far).add(control.target);
      eye.lookAt(control.target);
      eye.updateMatrixWorld();
      const seen = corners.map((corner) => corner.clone().project(eye));
      [low, high] = [Math.min(...seen.map(({ y }) => y)), Math.max(...seen.map(({ y }) => y))];
      if (seen.every(({ x, z }) => Math.abs(x) < 0.99 && z < 1) && high - low < 1.94) break;
    }
    const wide = 1000 * eye.aspect;
    eye.setViewOffset(wide, 1000, 0, -250 * (high + low), wide, 1000);
  }

  moveCamera(time) {
    const pose = this.run.robot(this.robot, time), [length, width] = this.run.meta.field.size, { eye, control } = this;
    this.eye.up.set(0, 0, 1);
    const robot = this.run.meta.robots[this.robot], side = robot && robot.alliance === "red" ? -1 : 1;
    this.cut.uCut.value = pose && ["follow", "behind"].includes(this.camera) ? 1 : 0;
    if (this.camera === "station") {
      const [x, y] = this.run.meta.field.stations[this.robot % 3 + (side < 0 ? 3 : 0)];
      eye.position.set(x + side * 0.05, y, 1.57);  // eye height of a standing adult, at the glass
      eye.lookAt(x + side * 6.5, 0.35 * y + 0.65 * width / 2, 0.2);
      control.target.set(x + side * 6.5, 0.35 * y + 0.65 * width / 2, 0.2);
    } else if (this.camera === "above") {
      const tall = Math.max(width / 2, length / 2 / eye.aspect) / Math.tan(eye.fov * Math.PI / 360) * 1.06;
      eye.up.set(0, 1, 0);
      eye.position.set(length / 2, width / 2, tall);
      eye.lookAt(length / 2, width / 2, 0);
      control.target.set(length / 2, width / 2, 0);
    } else if (this.cut.uCut.value) this.chase(pose, time, side);
    else eye.lookAt(control.target);
  }

  /** Follow a robot from behind, by heading or by direction of motion, inside the walls, unless the user turns the view. */
  chase(pose, time, side) {
    const { eye, control } = this, [x, y, z] = pose.place, size = this.run.meta.field.size, isFollow = this.camera === "follow";
    const target = new THREE.Vector3(x, y, z + 0.3);
    this.cut.uTo.value.copy(target);
    if (this.isHeld && this.kept) eye.position.add(target).sub(this.kept);
    else {
      const before = isFollow ? this.run.robot(this.robot, Math.max(this.run.start, time - 0.8)) : null;
      const [u, v] = before ? [x - before.place[0], y - before.place[1]] : [0, 0], isMoving = Math.hypot(u, v) > 0.25 && Math.hypot(u, v) < 6;
      const wanted = isFollow && this.isDriven ? (side < 0 ? Math.PI : 0) : !isFollow ? yawOf(pose.quat) : isMoving ? Math.atan2(v, u) : this.seenAt === null ? (side < 0 ? Math.PI : 0) : this.course;
      const since = this.seenAt === null ? -1 : time - this.seenAt, k = since < 0 || since > 0.5 ? 1 : 1 - Math.exp(-(isFollow ? 2.5 : 9) * since);
      this.course = (k === 1 ? 0 : this.course) + (k === 1 ? wanted : k * Math.atan2(Math.sin(wanted - this.course), Math.cos(wanted - this.course)));
      this.seenAt = time;
      const [far, up] = isFollow ? [3.6, 2.2] : [3.0, 1.7], at = [x - far * Math.cos(this.course), y - far * Math.sin(this.course)];
      const inside = at.map((one, q) => Math.min(Math.max(one, 0.25), size[q] - 0.25));
      eye.position.set(...inside, z + up + 0.7 * Math.hypot(at[0] - inside[0], at[1] - inside[1]));
    }
    this.kept = target;
    control.target.copy(target);
    const ahead = isFollow ? 0.6 : 0.8;
    eye.lookAt(x + ahead * Math.cos(this.course ?? 0), y + ahead * Math.sin(this.course ?? 0), z + 0.3);
    if (this.isHeld) eye.lookAt(target);
  }

  /** Reduce the resolution while drawing is too slow, and increase the resolution again while drawing is fast.
   * @param {number} stamp time stamp of this picture [ms] @param {number} since time since the last picture [ms] */
  keepUp(stamp, since) {
    this.pace += 0.15 * (Math.min(since, 1000) - this.pace);
    if (stamp - this.judgedAt < 400) return;
    this.judgedAt = stamp;
    const ratio = this.renderer.getPixelRatio(), wanted = this.pace > LATE ? 0.75 * ratio : this.pace < EARLY ? 1.15 * ratio : ratio;
    this.sharpen(Math.min(this.finest, Math.max(COARSEST * this.finest, wanted)));
  }

  /** Set the ratio of drawn pixels to CSS pixels. @param {number} ratio */
  sharpen(ratio) { if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio); }

  /** Fit the picture to the container, or to a width and height [px]. */
  resize(width = this.home.clientWidth, height = this.home.clientHeight) {
    if (!width || !height) return;
    this.renderer.setSize(width, height, false);
    const before = this.eye.aspect;
    this.eye.aspect = width / height;
    this.eye.updateProjectionMatrix();
    if (this.camera === "free" && Math.abs(before - this.eye.aspect) > 0.01) this.isHeld ? this.fit() : this.look("free");
  }
}

/** Make the geometry of a solid. @param {Uint8Array} bytes @param {SolidData} solid */
function geometryOf(bytes, { vertices, faces, scale }) {
  return shaped(Float32Array.from(unpack(bytes, vertices), (value) => value * scale), new THREE.BufferAttribute(new Uint16Array(unpack(bytes, faces).buffer), 1));
}

/** Make a geometry from vertices [m] and vertex indices. */
export function shaped(points, index) {
  const found = new THREE.BufferGeometry();
  found.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  found.setIndex(index);
  found.computeVertexNormals();
  return found;
}

/** Return whether the browser renders in software, which is too slow for shadows, smooth edges and fine spheres. */
export function drawsInSoftware() {
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

/** Make a texture from a picture that the function `draw` draws once. */
function drawn(width, height, draw) {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [width, height];
  draw(canvas.getContext("2d"));
  const found = new THREE.CanvasTexture(canvas);
  found.colorSpace = THREE.SRGBColorSpace;
  return found;
}

function radial(pen, size, stops) {
  const fade = pen.createRadialGradient(size / 2, size / 2, 0, size / 2, size / 2, size / 2);
  for (const [at, color] of stops) fade.addColorStop(at, color);
  pen.fillStyle = fade;
  pen.fillRect(0, 0, size, size);
}

/** Make a repeating picture of carpet grain. */
function grain() {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
  canvas.width = canvas.height = 96;
  const dots = pen.createImageData(96, 96);
  for (let k = 0, seed = 7; k < dots.data.length; k += 4) {
    seed = seed * 16807 % 2147483647;
    dots.data.set(seed % 2 ? [255, 255, 255, seed % 13] : [0, 0, 0, seed % 23], k);
  }
  pen.putImageData(dots, 0, 0);
  return canvas;
}

/** Make a material with a centered text. */
export function written(text, paper, ink, size, wide = 1) {
  const tall = 96, texture = drawn(tall * wide, tall, (pen) => {
    const { width } = pen.canvas;
    if (paper !== "transparent") {
      Object.assign(pen, { fillStyle: paper });
      pen.fillRect(0, 0, width, tall);
      pen.fillStyle = ink;
      pen.fillRect(8, 8, tall - 16, tall - 16);
    }
    Object.assign(pen, { fillStyle: paper === "transparent" ? ink : "#fff", textAlign: "center", textBaseline: "middle", font: `bold ${size * tall}px system-ui, sans-serif` });
    if (paper === "transparent") {  // an outline for text on white plates
      Object.assign(pen, { strokeStyle: "#14171c", lineWidth: 9, lineJoin: "round" });
      pen.strokeText(text, width / 2, tall / 2 + 4, width - 8);
    }
    pen.fillText(text, width / 2, tall / 2 + 4, width - 8);
  });
  texture.anisotropy = 4;
  return new THREE.MeshBasicMaterial({ map: texture, transparent: true, side: THREE.DoubleSide });
}
