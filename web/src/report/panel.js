// What is shown, and from where: boxes and buttons beside the picture.

export function connectPanel(viewer, place) {
  for (const box of place.querySelectorAll("[data-label]")) {
    box.addEventListener("change", () => viewer.setVisible(Number(box.dataset.label), box.checked));
    // A page that is shown again keeps its boxes.
    if (!box.checked) viewer.setVisible(Number(box.dataset.label), false);
  }
  for (const button of place.querySelectorAll("[data-glass]")) {
    button.addEventListener("click", () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(on));
      viewer.setGlass(Number(button.dataset.glass), on);
    });
  }
  const outlines = place.querySelector('[data-show="outlines"]');
  outlines.addEventListener("change", () => viewer.setOutlines(outlines.checked));
  if (!outlines.checked) viewer.setOutlines(false);
  for (const button of place.querySelectorAll("[data-view]")) {
    const side = button.dataset.view;
    button.addEventListener("click", () => (side === "fit" ? viewer.all() : viewer.look(side)));
  }
  const canvas = place.querySelector("canvas");
  const size = () => {
    const { clientWidth, clientHeight } = canvas;
    if (clientWidth && clientHeight) viewer.setSize(clientWidth, clientHeight, Math.min(devicePixelRatio, 2));
  };
  new ResizeObserver(size).observe(canvas);
  const colors = () => {
    const style = getComputedStyle(place);
    const own = (name) => style.getPropertyValue(name).trim();
    viewer.setColors({ background: own("--stage"), line: own("--line") });
  };
  colors();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", colors);
  viewer.after.push(() => place.setAttribute("data-drawn", ""));
}
