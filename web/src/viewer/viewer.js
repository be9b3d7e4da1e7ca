// Surfaces and contours in space, drawn when something changes. It knows a canvas and no page.

import {
  AmbientLight,
  BufferAttribute,
  BufferGeometry,
  Color,
  DirectionalLight,
  DoubleSide,
  HemisphereLight,
  LineBasicMaterial,
  LineLoop,
  Mesh,
  MeshBasicMaterial,
  PerspectiveCamera,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Body } from "./bodies.js";
import { Outline } from "./outlines.js";
import { bounds, numbers16 } from "./packed.js";
import { asked, distance, turned } from "./sight.js";

const OPENING = 30;

export class Viewer {
  // Throws where WebGL is absent. `data` is what the page's scene holds.
  constructor(canvas, data) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    const packed = (all) => all.map((own) => ({ ...own, places: numbers16(own.places) }));
    const [bodies, outlines] = [packed(data.bodies), packed(data.outlines)];
    const steps = bounds([...bodies, ...outlines].map((own) => own.places));
    this.corner = data.corner;
    this.step = data.step;
    this.steps = steps;
    this.bodies = bodies.map((body) => new Body(body, steps));
    this.outlines = outlines.map((outline) => new Outline(outline, steps));
    this.hasOutlines = true;
    this.lineColor = new Color(0x20242a);
    this.scene = new Scene();
    this.scene.add(...this.bodies.map((body) => body.group), ...this.outlines.map((own) => own.lines));
    this.up = new Vector3(...data.up);
    this.directions = {
      view: new Vector3(...data.view),
      front: new Vector3(...data.front),
      left: new Vector3(...data.right).negate(),
      top: new Vector3(...data.up),
    };
    this.camera = new PerspectiveCamera(OPENING, 1, 0.1, 100);
    this.camera.up.copy(this.up);
    this.light();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    // A wheel that passes over scrolls the page.
    this.controls.enableZoom = false;
    this.controls.addEventListener("change", () => this.draw());
    canvas.addEventListener("focus", () => (this.controls.enableZoom = true));
    canvas.addEventListener("blur", () => (this.controls.enableZoom = false));
    canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener("keydown", (event) => this.key(event));
    this.after = [];
    this.look("view");
  }

  // Light that stays with the viewer, as a lamp on the forehead, and some from everywhere.
  light() {
    const head = new DirectionalLight(0xffffff, 2.1);
    head.position.set(0.35, 0.6, 1);
    this.camera.add(head);
    const sky = new HemisphereLight(0xffffff, 0x8a8f98, 0.9);
    sky.position.copy(this.up);
    this.scene.add(this.camera, sky, new AmbientLight(0xffffff, 0.25));
  }

  // From a side, with all in sight.
  look(side) {
    const toward = this.directions[side].clone();
    this.controls.target.set(0, 0, 0);
    // Straight from above the front is below.
    if (toward.clone().cross(this.up).lengthSq() < 1e-6) {
      toward.addScaledVector(this.directions.front, 0.02);
    }
    this.camera.position.copy(toward.normalize());
    this.all();
  }

  // Everything in sight, from where the viewer stands.
  all() {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(offset.setLength(distance(OPENING, this.camera.aspect)));
    this.controls.update();
    this.draw();
  }

  // A place of the world in the middle of the picture, and near.
  goTo(at) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    this.controls.target.copy(this.place(at));
    this.camera.position.copy(this.controls.target).add(offset.setLength(distance(OPENING, this.camera.aspect) / 2));
    this.controls.update();
    this.draw();
  }

  key(event) {
    const what = asked(event);
    if (!what) return;
    event.preventDefault();
    const { target } = this.controls;
    const offset = this.camera.position.clone().sub(target);
    if (what.all) return this.all();
    if (what.turn) offset.copy(turned(offset, this.up, what.turn[0], what.turn[1]));
    if (what.away) offset.multiplyScalar(what.away);
    if (what.move) {
      const axes = [0, 1].map((axis) => new Vector3().setFromMatrixColumn(this.camera.matrixWorld, axis));
      target.addScaledVector(axes[0], what.move[0] * offset.length());
      target.addScaledVector(axes[1], -what.move[1] * offset.length());
    }
    this.camera.position.copy(target).add(offset);
    this.controls.update();
    this.draw();
  }

  // A place of the world in the viewer's space.
  place(at) {
    const { middle, radius } = this.steps;
    const along = (axis) => ((at[axis] - this.corner[axis]) / this.step - middle[axis]) / radius;
    return new Vector3(along(0), along(1), along(2));
  }

  body(label) {
    return this.bodies.find((body) => body.label === label);
  }

  setVisible(label, on) {
    this.body(label)?.setVisible(on);
    this.draw();
  }

  setGlass(label, on) {
    this.body(label)?.setGlass(on);
    this.draw();
  }

  setOutlines(on) {
    this.hasOutlines = on;
    this.draw();
  }

  setColors({ background, line }) {
    this.scene.background = new Color(background);
    this.lineColor = new Color(line);
    this.draw();
  }

  // Shows where a plane is, by four corners in the world; null for none.
  showPlane(corners, color) {
    if (this.plane) this.scene.remove(...this.plane);
    this.plane = null;
    if (corners) {
      const geometry = new BufferGeometry().setFromPoints(corners.map((corner) => this.place(corner)));
      const loop = new LineLoop(geometry, new LineBasicMaterial({ color }));
      const filled = geometry.clone().setIndex(new BufferAttribute(Uint16Array.of(0, 1, 2, 0, 2, 3), 1));
      const sheet = new Mesh(
        filled,
        new MeshBasicMaterial({ color, transparent: true, opacity: 0.18, side: DoubleSide, depthWrite: false }),
      );
      sheet.renderOrder = 3;
      this.plane = [loop, sheet];
      this.scene.add(...this.plane);
    }
    this.draw();
  }

  setSize(width, height, ratio) {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.all();
  }

  // Where places of the world are in the picture, from 0 to 1, down and to the right.
  onPicture(at) {
    const place = this.place(at).project(this.camera);
    return { left: (place.x + 1) / 2, top: (1 - place.y) / 2, isSeen: Math.abs(place.z) < 1 };
  }

  // Soon, once for all that has changed.
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.drawNow();
    });
  }

  drawNow() {
    this.outlines.forEach((own) => own.show(this.hasOutlines, this.bodies, this.lineColor));
    // As much depth as there is, for what there is.
    const away = this.camera.position.length();
    this.camera.near = Math.max(away - 1.05, 0.01);
    this.camera.far = away + 1.05;
    this.camera.updateProjectionMatrix();
    this.renderer.render(this.scene, this.camera);
    this.after.forEach((then) => then());
  }
}
