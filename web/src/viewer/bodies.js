// Surfaces of labels: what faces the viewer in the label's colour, what is seen from within darker.

import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  Color,
  FrontSide,
  Group,
  Mesh,
  MeshPhongMaterial,
  SRGBColorSpace,
} from "three";
import { numbers16, numbers32, unpacked } from "./packed.js";

const GLASS = 0.22;

// A label's surface, in the viewer's space.
export class Body {
  constructor({ label, color, glass, places, corners, wide }, space) {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(unpacked(places, space), 3));
    geometry.setIndex(new BufferAttribute(wide ? numbers32(corners) : numbers16(corners), 1));
    geometry.computeVertexNormals();
    const [red, green, blue] = color.map((part) => part / 255);
    const own = new Color().setRGB(red, green, blue, SRGBColorSpace);
    // Surfaces stand back a little, so that contours on them are seen.
    const back = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 8 };
    this.label = label;
    this.front = new MeshPhongMaterial({ color: own, shininess: 18, specular: 0x222222, side: FrontSide, ...back });
    this.back = new MeshPhongMaterial({
      color: own.clone().multiplyScalar(0.45),
      shininess: 0,
      side: BackSide,
      ...back,
      polygonOffsetUnits: 16,
    });
    this.inside = new Mesh(geometry, this.back);
    this.outside = new Mesh(geometry, this.front);
    this.group = new Group().add(this.inside, this.outside);
    this.setGlass(glass);
  }

  get isVisible() {
    return this.group.visible;
  }

  setVisible(on) {
    this.group.visible = on;
  }

  // Glass is drawn last, its front alone, and hides nothing.
  setGlass(on) {
    this.glass = on;
    this.front.transparent = on;
    this.front.opacity = on ? GLASS : 1;
    this.front.depthWrite = !on;
    this.front.needsUpdate = true;
    this.outside.renderOrder = on ? 2 : 0;
    this.inside.visible = !on;
  }
}
