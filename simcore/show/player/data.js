// Reader of the frames that simcore/show/frames.py writes: one packed block of a recording, or single rows of a live run.

export const AWAY = -32768;
const UNIT = 32767;
const ROBOT = 11, PART = 7, CORNERS = 12;
const JUMP = 1200;  // [mm]; a longer step between two frames means that a robot or piece was moved by hand, and is not interpolated

/** @type {(f: (d: number) => number) => Point} */
const xyz = (f) => [f(0), f(1), f(2)];

/** Decompress a gzipped base64 text to bytes. @param {string} text */
export async function inflate(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
}

/** Unpack 16-bit rows packed by `pack` in frames.py. @param {Uint8Array} bytes @param {Place} place */
export function unpack(bytes, [offset, rows, columns]) {
  const n = rows * columns, found = new Int16Array(n);
  for (let c = 0, k = 0; c < columns; c++) {
    for (let r = 0, sum = 0; r < rows; r++, k++) {
      sum += bytes[offset + k] | (bytes[offset + n + k] << 8);
      found[r * columns + c] = sum;
    }
  }
  return found;
}

/** Return the index of the last of ascending times that is not after a time; 0 if all times are later. @param {ArrayLike<number>} times @param {number} time */
export function rowAt(times, time, n = times.length) {
  let low = 0, high = n;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time + 1e-6) low = middle; else high = middle;
  }
  return low;
}

/** Return the value of a change record at a time; null before the first change.
 * @template T @param {Changes<T> | undefined} changes @param {number} time @returns {T | null} */
export function valueAt(changes, time) {
  return changes && changes.times.length && changes.times[0] <= time + 1e-6 ? changes.values[rowAt(changes.times, time)] : null;
}

/** Group of columns of frames, with times and rows. */
class Group {
  /** @param {number} width @param {Float64Array} times @param {Int16Array} rows */
  constructor(width, times = new Float64Array(0), rows = new Int16Array(0)) {
    this.width = width;
    this.times = times;
    this.rows = rows;
    this.n = times.length;
  }

  /** @param {number} time @param {Int16Array} row */
  append(time, row) {
    if (this.n && time <= this.times[this.n - 1]) this.n = 0;  // a new run has begun
    if (this.n === this.times.length) {
      const times = new Float64Array(2 * this.n + 64), rows = new Int16Array((2 * this.n + 64) * this.width);
      times.set(this.times);
      rows.set(this.rows);
      [this.times, this.rows] = [times, rows];
    }
    this.times[this.n] = time;
    this.rows.set(row, this.n * this.width);
    this.n++;
  }

  /** Return the offsets of the rows before and after a time, and the fraction of the interval between both rows. @param {number} time */
  at(time) {
    const i = rowAt(this.times, time, this.n), j = Math.min(i + 1, this.n - 1), span = this.times[j] - this.times[i];
    return { a: i * this.width, b: j * this.width, k: span > 0 ? Math.min(1, Math.max(0, (time - this.times[i]) / span)) : 0, n: this.n };
  }
}

/** Data of a run: the objects to draw, and the motion of the objects. All returned lengths are in meters. */
export class Run {
  /** @param {Meta} meta @param {Uint8Array} bytes */
  constructor(meta, bytes) {
    this.meta = meta;
    this.bytes = bytes;
    /** @type {Record<string, Group>} */
    this.groups = {};
    for (const [name, group] of Object.entries(meta.groups)) {
      if (!group.rows) { this.groups[name] = new Group(group.width); continue; }
      const steps = unpack(bytes, group.times);
      const times = Float64Array.from(steps);
      for (let i = 0, sum = meta.start; i < times.length; i++) times[i] = sum += steps[i] / 1000;
      this.groups[name] = new Group(group.width, times, unpack(bytes, group.rows));
    }
    /** @type {number[]} */
    this.partsFrom = [];
    let first = 0;
    for (const robot of meta.robots) { this.partsFrom.push(first); first += robot.parts; }
    /** @type {{ kind: number, column: number }[]} */
    this.pieces = [];  // kind and first column of each piece
    let column = 0;
    meta.kinds.forEach((kind, number) => {
      for (let q = 0; q < kind.count; q++) { this.pieces.push({ kind: number, column }); column += kind.round ? 4 : 8; }
    });
  }

  get start() { return this.meta.live ? (this.groups.robots.n ? this.groups.robots.times[0] : 0) : this.meta.start; }
  get end() { return this.meta.live ? (this.groups.robots.n ? this.groups.robots.times[this.groups.robots.n - 1] : 0) : this.meta.end; }

  /** Return the state of a lit field element: on, off, pulsing or purple; null if unknown. @param {string} name @param {number} time */
  lamp(name, time) { return valueAt(this.meta.lamps[name], time); }

  /** Return the number of pieces in a scoring place or on a level. @param {string} name @param {number} time */
  count(name, time) { return valueAt(this.meta.cells[name], time) ?? 0; }

  /** Return the text of a line of the score board, or null before the first text. @param {string} label @param {number} time */
  text(label, time) { return valueAt(this.meta.board.find((item) => item.label === label), time); }

  /** Sides with a score: the alliances, or both runs on a page of two runs. @returns {{ label: string, side: string, ink: string }[]} */
  get sides() {
    const runs = this.meta.robots.filter((robot) => robot.is_run);
    return runs.length ? runs.map(({ name, ink }) => ({ label: name, side: "", ink })) : ["blue", "red"].map((side) => ({ label: side, side, ink: `var(--${side})` }));
  }

  /** Append a live frame, which consists of a time and one row of each group, and return the time. @param {ArrayBuffer} buffer */
  append(buffer) {
    const time = new DataView(buffer).getFloat64(0, true);
    let offset = 8;
    for (const name of ["robots", "parts", "pieces", "lines"]) {
      const group = this.groups[name];
      if (!group.width) continue;
      group.append(time, new Int16Array(buffer, offset, group.width));
      offset += 2 * group.width;
    }
    return time;
  }

  /** Return the pose of a robot, or null if unknown: position, quaternion x y z w, estimated x y yaw, active intake.
   * @param {number} number @param {number} time @returns {Pose | null} */
  robot(number, time) {
    const { rows } = this.groups.robots, { a, b, k, n } = this.groups.robots.at(time), from = a + ROBOT * number, to = b + ROBOT * number;
    if (!n || rows[from] === AWAY) return null;
    const pose = between(rows, from, to, k);
    pose.belief = null;
    if (rows[from + 7] !== AWAY) {
      const near = rows[to + 7] !== AWAY && Math.hypot(rows[to + 7] - rows[from + 7], rows[to + 8] - rows[from + 8]) < JUMP ? k : 0;
      const turn = Math.atan2(Math.sin((rows[to + 9] - rows[from + 9]) / 1e4), Math.cos((rows[to + 9] - rows[from + 9]) / 1e4));
      pose.belief = [(rows[from + 7] + near * (rows[to + 7] - rows[from + 7])) / 1000,
        (rows[from + 8] + near * (rows[to + 8] - rows[from + 8])) / 1000, rows[from + 9] / 1e4 + near * turn];
    }
    pose.active = rows[from + 10] > 0;
    return pose;
  }

  /** Return the pose of a moving part in the robot frame, or null while the part is hidden. @param {number} robot @param {number} number @param {number} time @returns {Pose | null} */
  part(robot, number, time) {
    const { rows } = this.groups.parts, { a, b, k, n } = this.groups.parts.at(time), c = PART * (this.partsFrom[robot] + number);
    if (!n || !(rows[a + c + 3] || rows[a + c + 4] || rows[a + c + 5] || rows[a + c + 6])) return null;
    return between(rows, a + c, b + c, k);
  }

  /** Call `put(row, x, y, z, state, rows, a, b, k)` for each piece; interpolate the quaternions at a and b by k.
   * @param {number} time
   * @param {(row: number, x: number, y: number, z: number, state: number, rows: Int16Array, a: number, b: number, k: number) => void} put */
  eachPiece(time, put) {
    const { rows } = this.groups.pieces, { a, b, k, n } = this.groups.pieces.at(time);
    if (!n) return;
    for (let row = 0; row < this.pieces.length; row++) {
      const c = this.pieces[row].column, i = a + c, j = b + c, state = rows[i + 3];
      const isNear = state && rows[j + 3] && (state > 2) === (rows[j + 3] > 2) && (state < 3 || state === rows[j + 3]) &&
        Math.abs(rows[j] - rows[i]) + Math.abs(rows[j + 1] - rows[i + 1]) < JUMP;
      const s = isNear ? k : 0;
      put(row, (rows[i] + s * (rows[j] - rows[i])) / 1000, (rows[i + 1] + s * (rows[j + 1] - rows[i + 1])) / 1000,
        (rows[i + 2] + s * (rows[j + 2] - rows[i + 2])) / 1000, state, rows, i + 4, j + 4, s);
    }
  }

  /** Return the positions [x, y, z] of a piece on the field or in flight between two times [m].
   * @param {number} row @param {number} from @param {number} to @returns {Point[]} */
  wayOf(row, from, to) {
    const group = this.groups.pieces, c = this.pieces[row].column;
    /** @type {Point[]} */
    const found = [];
    for (let i = rowAt(group.times, from, group.n); i < group.n && group.times[i] <= to + 1e-6; i++) {
      const o = i * group.width + c;
      if (group.times[i] >= from - 0.021 && group.rows[o + 3] && group.rows[o + 3] < 3) found.push(xyz((d) => group.rows[o + d] / 1000));
    }
    return found;
  }

  /** Return the path of a robot between two times [m], split where the robot was moved by hand.
   * @param {number} number @param {number} from @param {number} to @returns {[number, number][][]} */
  pathOf(number, from, to, step = 0.1) {
    /** @type {[number, number][][]} */
    const ways = [[]];
    for (let time = Math.max(from, this.start); time <= to + 1e-9; time += step) {
      const pose = this.robot(number, time);
      if (!pose) continue;
      const last = ways.at(-1).at(-1);
      if (last && Math.hypot(last[0] - pose.place[0], last[1] - pose.place[1]) > 12 * step) ways.push([]);
      ways.at(-1).push([pose.place[0], pose.place[1]]);
    }
    return ways;
  }

  /** Return the segments [from, to] of the camera lines at a time; the first segment of a line begins at the camera. @param {number} time @returns {[Point, Point][]} */
  lines(time) {
    const { rows } = this.groups.lines, { a, n } = this.groups.lines.at(time);
    /** @type {[Point, Point][]} */
    const found = [];
    if (!n) return found;
    for (let c = a; c < a + this.groups.lines.width; c += 3 * CORNERS) {
      for (let q = 0; q + 1 < CORNERS && rows[c + 3 * q + 3] !== AWAY; q++) {
        found.push([xyz((d) => rows[c + 3 * q + d] / 1000), xyz((d) => rows[c + 3 * q + 3 + d] / 1000)]);
      }
    }
    return found;
  }
}

/** Interpolate a pose between two rows of x y z [mm] and a quaternion w x y z.
 * @param {Int16Array} rows @param {number} i @param {number} j @param {number} k @returns {Pose} */
function between(rows, i, j, k) {
  if (rows[j] === AWAY || Math.abs(rows[j] - rows[i]) + Math.abs(rows[j + 1] - rows[i + 1]) > JUMP) k = 0;
  const place = xyz((d) => (rows[i + d] + k * (rows[j + d] - rows[i + d])) / 1000);
  return { place, quat: turned(rows, i + 3, j + 3, k) };
}

/** Interpolate a quaternion between two rows of w x y z; return x y z w.
 * @param {Int16Array} rows @param {number} i @param {number} j @param {number} k @returns {Quaternion} */
export function turned(rows, i, j, k) {
  let dot = 0;
  for (let d = 0; d < 4; d++) dot += rows[i + d] * rows[j + d];
  const sign = dot < 0 ? -1 : 1, mix = [1, 2, 3, 0].map((d) => rows[i + d] + k * (sign * rows[j + d] - rows[i + d]));
  const size = Math.hypot(...mix) || UNIT;
  return /** @type {Quaternion} */ (mix.map((value) => value / size));
}

/** Return the yaw [rad] of a quaternion x y z w. @param {Quaternion} quat */
export function yawOf([x, y, z, w]) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}
