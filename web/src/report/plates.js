// A section, larger, and where it is in space.

export function connectPlates(viewer, corners) {
  const dialog = document.getElementById("large");
  const plates = [...document.querySelectorAll("[data-plate]")];
  if (!dialog || plates.length === 0) return;
  // The plane of the one that was looked at last stays in space until somebody wants it away.
  const away = document.createElement("button");
  away.type = "button";
  away.textContent = "hide section";
  away.hidden = true;
  away.addEventListener("click", () => {
    viewer.showPlane(null);
    away.hidden = true;
  });
  document.querySelector("#viewer .views")?.append(away);
  let shown = 0;
  const show = (number) => {
    shown = (number + plates.length) % plates.length;
    const plate = plates[shown];
    dialog.querySelector(".sheet").replaceChildren(...[...plate.children].map((child) => child.cloneNode(true)));
    const words = plate.parentElement.querySelector("figcaption").cloneNode(true);
    dialog.querySelector(".turn p").replaceChildren(...words.childNodes);
    viewer?.showPlane(corners[shown], "#e0672b");
    away.hidden = false;
    if (!dialog.open) dialog.showModal();
  };
  plates.forEach((plate, number) => plate.addEventListener("click", () => show(number)));
  for (const button of dialog.querySelectorAll("[data-step]")) {
    button.addEventListener("click", () => show(shown + Number(button.dataset.step)));
  }
  dialog.querySelector("[data-close]").addEventListener("click", () => dialog.close());
  // Beside the sheet is the backdrop.
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  dialog.addEventListener("keydown", ({ key }) => {
    if (key === "ArrowLeft") show(shown - 1);
    if (key === "ArrowRight") show(shown + 1);
  });
}
