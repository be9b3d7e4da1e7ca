import assert from "node:assert/strict";
import { test } from "node:test";
import { Body } from "../src/viewer/bodies.js";

const base64 = (...numbers) => btoa(String.fromCharCode(...new Uint8Array(Uint16Array.from(numbers).buffer)));

// A triangle from 0 to 10 steps.
const data = {
  label: 3,
  color: [255, 128, 0],
  glass: true,
  places: Uint16Array.of(0, 0, 0, 10, 0, 0, 0, 10, 0),
  corners: base64(0, 1, 2),
  wide: false,
};
const space = { middle: [0, 0, 0], radius: 10 };

test("glass hides nothing and is drawn after what is solid", () => {
  const body = new Body(data, space);
  assert.ok(body.front.transparent && !body.front.depthWrite && !body.inside.visible);
  const glass = body.outside.renderOrder;
  body.setGlass(false);
  assert.ok(!body.front.transparent && body.front.depthWrite && body.inside.visible);
  assert.ok(glass > body.outside.renderOrder);
});

test("a body is where its places are, and faces as its corners go", () => {
  const { geometry } = new Body(data, space).outside;
  assert.deepEqual([...geometry.getAttribute("position").array], [0, 0, 0, 1, 0, 0, 0, 1, 0]);
  assert.deepEqual([...geometry.getAttribute("normal").array.slice(0, 3)], [0, 0, 1]);
});
