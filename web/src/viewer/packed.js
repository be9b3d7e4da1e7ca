// Places and corners as the page has them: base64 of little-endian numbers, places as whole numbers
// of steps from a corner.

// The bytes of a text in base64.
export function bytes(text) {
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}

export function numbers16(text) {
  const view = new DataView(bytes(text).buffer);
  return Uint16Array.from({ length: view.byteLength / 2 }, (_, i) => view.getUint16(2 * i, true));
}

export function numbers32(text) {
  const view = new DataView(bytes(text).buffer);
  return Uint32Array.from({ length: view.byteLength / 4 }, (_, i) => view.getUint32(4 * i, true));
}

// The middle of the box around places, and how far they reach from there, in steps.
export function bounds(packed) {
  const least = [Infinity, Infinity, Infinity];
  const most = [-Infinity, -Infinity, -Infinity];
  for (const places of packed) {
    for (let i = 0; i < places.length; i++) {
      const axis = i % 3;
      if (places[i] < least[axis]) least[axis] = places[i];
      if (places[i] > most[axis]) most[axis] = places[i];
    }
  }
  if (!(most[0] >= least[0])) return { middle: [0, 0, 0], radius: 1 };
  const middle = least.map((low, axis) => (low + most[axis]) / 2);
  let radius = 0;
  for (const places of packed) {
    for (let i = 0; i < places.length; i += 3) {
      const [x, y, z] = middle;
      radius = Math.max(radius, Math.hypot(places[i] - x, places[i + 1] - y, places[i + 2] - z));
    }
  }
  return { middle, radius: radius || 1 };
}

// Places in the viewer's space: the middle is its origin, and the radius its unit. Coordinates of
// the world, however large, never meet single precision.
export function unpacked(places, { middle, radius }) {
  const scale = 1 / radius;
  return Float32Array.from(places, (place, i) => (place - middle[i % 3]) * scale);
}

// The pairs of neighbours on lines of so many points each, one after the other.
export function pairs(runs) {
  const ends = [];
  let first = 0;
  for (const run of runs) {
    for (let i = 1; i < run; i++) ends.push(first + i - 1, first + i);
    first += run;
  }
  return Uint32Array.from(ends);
}
