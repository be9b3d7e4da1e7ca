// The report's page: what is in it works without this script, but for what can be turned.

import { Viewer } from "../viewer/viewer.js";
import { connectPanel } from "./panel.js";
import { connectPlates } from "./plates.js";
import { connectSigns } from "./signs.js";

const data = JSON.parse(document.getElementById("data").textContent);
const viewer = data.scene ? made(data.scene) : null;
if (viewer) {
  connectPanel(viewer, document.getElementById("viewer"));
  connectSigns(viewer, document.getElementById("viewer"), data.marks);
}
connectPlates(viewer, data.plates);

// The viewer; without WebGL the page says so.
function made(scene) {
  const place = document.getElementById("viewer");
  try {
    place.hidden = false;
    return new Viewer(place.querySelector("canvas"), scene);
  } catch (error) {
    place.hidden = true;
    document.getElementById("no-webgl").hidden = false;
    console.info(`nothing is drawn in space: ${error.message}`);
    return null;
  }
}
