// Where a camera is: at a distance from what it looks at, with up as far up as that goes.

import { Quaternion, Vector3 } from "three";

// How near to straight up or down a camera comes, as an angle.
const POLE = 0.02;

// Turns the offset of a camera from its target by angles around up and sideways.
export function turned(offset, up, aside, over) {
  const result = offset.clone();
  result.applyQuaternion(new Quaternion().setFromAxisAngle(up, aside));
  const sideways = new Vector3().crossVectors(up, result);
  if (sideways.lengthSq() < 1e-12) return result;
  const now = result.angleTo(up);
  const next = Math.min(Math.max(now + over, POLE), Math.PI - POLE);
  return result.applyQuaternion(new Quaternion().setFromAxisAngle(sideways.normalize(), next - now));
}

// How far away a camera sees all of a ball of radius 1: its opening is given upward, and the shape
// of its picture as width over height.
export function distance(degrees, aspect) {
  const half = (degrees * Math.PI) / 360;
  const narrow = aspect < 1 ? Math.atan(Math.tan(half) * aspect) : half;
  return 1 / Math.sin(narrow);
}

// What a key asks for: angles to turn by, parts of the picture to move by, a factor to go away
// by, or to see all.
export function asked({ key, shiftKey, ctrlKey, altKey, metaKey }) {
  if (ctrlKey || altKey || metaKey) return null;
  const arrows = {
    ArrowLeft: [-1, 0],
    ArrowRight: [1, 0],
    ArrowUp: [0, -1],
    ArrowDown: [0, 1],
  };
  const way = arrows[key];
  if (way) return shiftKey ? { move: way.map((part) => part * 0.05) } : { turn: way.map((part) => part * 0.12) };
  if (key === "+" || key === "=") return { away: 1 / 1.2 };
  if (key === "-" || key === "_") return { away: 1.2 };
  if (key === "f" || key === "F" || key === "Home") return { all: true };
  return null;
}
