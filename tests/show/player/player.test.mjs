// What of the player needs no browser: `node --test`, with a run that Python has written (test_player_script.py).
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

const player = new URL("../../../simcore/show/player/", import.meta.url);
const { AWAY, Run, inflate, rowAt, turned, unpack, valueAt, yawOf } = await import(new URL("data.js", player).href);
const { ticks, words } = await import(new URL("charts.js", player).href);
const { reach } = await import(new URL("robot_model.js", player).href);
const { cueOf } = await import(new URL("sound.js", player).href);
const { rectangle, squares, viewOf } = await import(new URL("top.js", player).href);

const near = (seen, wanted, within) => wanted.forEach((value, k) =>
  assert.ok(Math.abs(seen[k] - value) <= within, `[${seen}] is not [${wanted}]`));

const { run: text, data, expected } = JSON.parse(readFileSync(process.env.SIMCORE_RUN, "utf8"));
const meta = JSON.parse(new TextDecoder().decode(await inflate(text)));
const run = new Run(meta, await inflate(data));

test("a block is read as it was packed", () => {
  const rows = unpack(Uint8Array.of(1, 1, 0, 0, 0, 0, 1, 0), [0, 2, 2]);  // as in the docstring of `pack`
  assert.deepEqual([...rows], [1, 256, 2, 256]);
  const full = unpack(Uint8Array.of(0x00, 0xff, 0x80, 0xff), [0, 2, 1]);  // over the end of 16 bits
  assert.deepEqual([...full], [AWAY, 32767]);
});

test("robots, beliefs and pieces are where Python says", () => {
  for (const { time, robot, belief, pieces } of expected) {
    const pose = run.robot(0, time + 1e-7);
    near(pose.place, robot.slice(0, 3), 6e-4);
    assert.ok(Math.abs(yawOf(pose.quat) - robot[3]) < 1e-3);
    near(pose.belief, belief, 1e-3);
    const seen = [];
    run.eachPiece(time + 1e-7, (row, x, y, z, state) => seen.push([x, y, z, state]));
    assert.equal(seen.length, pieces.length);
    seen.forEach((piece, k) => near(pieces[k][3] ? piece : piece.slice(3), pieces[k][3] ? pieces[k] : [0], 1.1e-3));
  }
});

test("between two frames a robot is between two places, and one that was put elsewhere jumps", () => {
  const live = new Run({ ...meta, live: true, groups: { robots: { width: 11 }, parts: { width: 0 }, pieces: { width: 0 }, lines: { width: 0 } }, kinds: [] }, new Uint8Array());
  const frame = (time, x) => {
    const buffer = new ArrayBuffer(8 + 22), row = new Int16Array(buffer, 8);
    new DataView(buffer).setFloat64(0, time, true);
    row.set([x, 500, 0, 32767, 0, 0, 0, AWAY, 0, 0, 0]);
    return buffer;
  };
  assert.equal(live.robot(0, 0), null);
  [[0, 1000], [0.1, 1200], [0.2, 9000]].forEach(([time, x]) => live.append(frame(time, x)));
  near(live.robot(0, 0.05).place, [1.1, 0.5, 0], 1e-9);
  near(live.robot(0, 0.15).place, [1.2, 0.5, 0], 1e-9);
  near(live.robot(0, 9).place, [9, 0.5, 0], 1e-9);
  assert.equal(live.robot(0, 0).belief, null);
  assert.equal(live.pathOf(0, 0, 0.2).length, 2, "it was carried in between");
  assert.deepEqual([live.start, live.end], [0, 0.2]);
});

test("a quaternion takes the short way, and is one", () => {
  const half = 32767 * Math.SQRT1_2, rows = Int16Array.of(32767, 0, 0, 0, -half, 0, 0, -half);
  const middle = turned(rows, 0, 4, 0.5);
  assert.ok(Math.abs(Math.hypot(...middle) - 1) < 1e-12);
  assert.ok(Math.abs(yawOf(middle) - Math.PI / 4) < 1e-4);
});

test("rows by time", () => {
  assert.deepEqual([-1, 0, 0.5, 1, 2, 9].map((time) => rowAt([0, 1, 2], time)), [0, 0, 0, 1, 2, 2]);
  assert.equal(rowAt([], 1), 0);
});

test("a line of a board is not there before its first value, nor after it has ended", () => {
  const level = { times: [163, 165], values: ["Level1", null] };
  assert.deepEqual([0.5, 162.99, 163, 164.9, 165, 900].map((time) => valueAt(level, time)), [null, null, "Level1", "Level1", null, null]);
  assert.deepEqual([valueAt(undefined, 1), valueAt({ times: [], values: [] }, 1)], [null, null]);
  const lit = new Run({ ...meta, lamps: { goal: { times: [1], values: ["pulsing"] } } }, new Uint8Array(run.bytes));
  assert.deepEqual([lit.lamp("goal", 0.9), lit.lamp("goal", 1.1)], [null, "pulsing"]);
});

test("scales have round numbers", () => {
  assert.deepEqual(ticks(0, 20, 5), [0, 5, 10, 15, 20]);
  assert.deepEqual(ticks(-0.13, 0.31, 5), [-0.1, 0, 0.1, 0.2, 0.3]);
});

test("values are written shortly, and none for what there is not", () => {
  assert.deepEqual([null, Infinity, 3, 0.00123, 2.345, 1234.5].map(words), ["", "", "3", "0.0012", "2.35", "1235"]);
});

test("measures go from the lowest to the highest corner", () => {
  assert.deepEqual(reach([[1, 5, 0], [-1, 2, 3], [0, 9, 1]]), [[-1, 2, 0], [1, 9, 3]]);
});

test("a box from above is the rectangle along its longest edge", () => {
  const half = Math.PI / 12, size = [0.3, 0.12, 0.1], turnedBy = (degrees, axis) => {
    const angle = degrees * Math.PI / 360;
    return [..."xyz"].map((name) => name === axis ? Math.sin(angle) : 0).concat(Math.cos(angle));
  };
  near(rectangle([0.6, 0.2, 0.1], [0, 0, Math.sin(half), Math.cos(half)]), [0.6, 0.2, Math.PI / 6], 1e-9);
  near(rectangle(size, turnedBy(130, "z")), [0.3, 0.12, 130 * Math.PI / 180], 1e-9);
  near(rectangle(size, turnedBy(90, "x")), [0.3, 0.1, 0], 1e-9);
  near(rectangle(size, turnedBy(90, "y")), [0.12, 0.1, Math.PI / 2], 1e-9);
  near(rectangle(size, turnedBy(30, "y")), [0.3 * Math.cos(Math.PI / 6) + 0.1 * Math.sin(Math.PI / 6), 0.12, 0], 1e-9);
  near(rectangle([0.1, 0.2, 0.6], [0, 0, 0, 1]).slice(0, 2), [0.2, 0.1], 1e-9);
});

test("squares of a heat map count every place once, those beside the field at its edge", () => {
  assert.deepEqual(squares([8, 4], [[0.1, 0.1], [0.4, 0.3], [-2, 0.2], [7.9, 9]]), [[0, 0, 3], [7.5, 3.5, 1]]);
});

test("what stands across the field's edge is seen to its end, and what is far away does not shrink the field", () => {
  const outline = (...corners) => ["name", "blue", corners];
  const size = [8, 4], station = outline([-0.7, 3], [1, 4.6], [0, 5]), far = outline([8, 0], [38, 0], [8, -30]);
  const seen = viewOf({ ...meta.field, size, outlines: [station, far] });
  near(seen, [-0.975, -1.5, 9.5, 5], 1e-9);
});

test("a match sounds when it begins, changes and ends, and not when time is moved", () => {
  const at = (time, period, enabled, left = 100) => ({ time, period, enabled, left });
  assert.equal(cueOf(null, at(0.1, "auto", true)), "start");
  assert.equal(cueOf(at(14.9, "auto", true), at(15, "auto", false)), "stop");
  assert.equal(cueOf(at(30, "shift 1", true), at(30.1, "shift 2", true)), "change");
  assert.equal(cueOf(at(130, "shift 4", true), at(130.1, "end game", true, 30)), "last");
  assert.equal(cueOf(at(160, "end game", true), at(160.1, "over", false, 0)), "end");
  assert.equal(cueOf(at(30, "shift 1", true), at(60, "shift 2", true)), null);
});
