import assert from "node:assert/strict";
import { test } from "node:test";
import { bounds, numbers16, numbers32, pairs, unpacked } from "../src/viewer/packed.js";

const base64 = (...bytes) => btoa(String.fromCharCode(...bytes));

test("numbers are little-endian whatever the machine", () => {
  assert.deepEqual([...numbers16(base64(1, 0, 0, 1, 255, 255))], [1, 256, 65535]);
  assert.deepEqual([...numbers32(base64(4, 3, 2, 1))], [0x01020304]);
  assert.equal(numbers16("").length, 0);
});

test("the ball around places is the viewer's space", () => {
  const places = [Uint16Array.of(0, 10, 20, 6, 10, 20), Uint16Array.of(0, 10, 28)];
  const space = bounds(places);
  assert.deepEqual(space.middle, [3, 10, 24]);
  assert.equal(space.radius, 5);
  const near = (one, other) => assert.ok(one.every((part, i) => Math.abs(part - other[i]) < 1e-6), `${one}`);
  near([...unpacked(places[0], space)], [-0.6, 0, -0.8, 0.6, 0, -0.8]);
});

test("nothing, and a single place, have a space too", () => {
  assert.equal(bounds([]).radius, 1);
  assert.equal(bounds([Uint16Array.of(7, 7, 7)]).radius, 1);
});

test("lines do not join", () => {
  assert.deepEqual([...pairs(Uint32Array.of(3, 1, 2))], [0, 1, 1, 2, 4, 5]);
});
