import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { asked, distance, turned } from "../src/viewer/sight.js";

const up = new Vector3(0, 0, 1);

test("turning keeps the distance, and height when it is sideways", () => {
  const offset = new Vector3(1, 2, 3);
  const aside = turned(offset, up, 0.7, 0);
  assert.ok(Math.abs(aside.length() - offset.length()) < 1e-12);
  assert.ok(Math.abs(aside.z - 3) < 1e-12);
  const higher = turned(offset, up, 0, -0.2);
  assert.ok(Math.abs(offset.angleTo(up) - higher.angleTo(up) - 0.2) < 1e-12);
});

test("a camera comes near to the poles and not over them", () => {
  let offset = new Vector3(1, 0, 0.5);
  for (let i = 0; i < 100; i++) offset = turned(offset, up, 0, -0.2);
  assert.ok(offset.angleTo(up) > 0.01 && offset.angleTo(up) < 0.03);
  assert.ok(Math.abs(offset.length() - Math.hypot(1, 0.5)) < 1e-9);
});

test("all of a ball is in sight, also where the picture is narrow", () => {
  assert.ok(Math.abs(distance(60, 2) - 2) < 1e-12);
  assert.ok(Math.abs(distance(60, 1) - 2) < 1e-12);
  const narrow = distance(60, 0.5);
  assert.ok(Math.abs(Math.asin(1 / narrow) - Math.atan(Math.tan(Math.PI / 6) / 2)) < 1e-12);
});

test("keys ask for what the page says", () => {
  assert.deepEqual(asked({ key: "ArrowLeft" }), { turn: [-0.12, 0] });
  assert.deepEqual(asked({ key: "ArrowUp", shiftKey: true }), { move: [0, -0.05] });
  assert.ok(asked({ key: "+" }).away < 1 && asked({ key: "-" }).away > 1);
  assert.deepEqual(asked({ key: "F" }), { all: true });
  assert.equal(asked({ key: "Tab" }), null);
  assert.equal(asked({ key: "f", ctrlKey: true }), null, "to find is the browser's");
});
