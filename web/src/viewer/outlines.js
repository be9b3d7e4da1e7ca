// Contours of sections as lines; one shows where a label beside it does.

import { BufferAttribute, BufferGeometry, LineBasicMaterial, LineSegments } from "three";
import { numbers32, pairs, unpacked } from "./packed.js";

export class Outline {
  constructor({ labels, unknown, places, runs }, space) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(unpacked(places, space), 3));
    geometry.setIndex(new BufferAttribute(pairs(numbers32(runs)), 1));
    this.labels = labels;
    this.unknown = unknown;
    this.material = new LineBasicMaterial({ transparent: true });
    this.lines = new LineSegments(geometry, this.material);
    this.lines.renderOrder = 1;
  }

  // Borders of what is unknown belong to no label's shape: they are fainter, and stay. So are those
  // of glass, which would hide what is in it.
  show(on, bodies, color) {
    const shown = bodies.filter((body) => body.isVisible && this.labels.includes(body.label));
    this.lines.visible = on && (this.unknown || shown.length > 0);
    this.material.color.set(color);
    this.material.opacity = this.unknown || shown.every((body) => body.glass) ? 0.22 : 0.75;
  }
}
