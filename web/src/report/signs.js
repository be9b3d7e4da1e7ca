// Places with a letter or a number, over the picture; whoever chooses one goes there.

export function connectSigns(viewer, place, marks) {
  const signs = place.querySelector(".signs");
  const all = marks.map((mark) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = `sign ${mark.kind}`;
    button.textContent = mark.sign;
    button.title = mark.what;
    button.setAttribute("aria-label", `${mark.sign}: ${mark.what}`);
    button.addEventListener("click", () => viewer.goTo(mark.at));
    signs.append(button);
    return { mark, button };
  });
  const shows = (kind) => place.querySelector(`[data-show="${kind}"]`);
  const follow = () => {
    for (const { mark, button } of all) {
      const { left, top, isSeen } = viewer.onPicture(mark.at);
      button.hidden = !isSeen || !shows(mark.kind).checked || left < 0 || left > 1 || top < 0 || top > 1;
      button.style.left = `${100 * left}%`;
      button.style.top = `${100 * top}%`;
    }
  };
  viewer.after.push(follow);
  for (const kind of ["scan", "look"]) {
    const box = shows(kind);
    box.addEventListener("change", follow);
    box.parentElement.hidden = !marks.some((mark) => mark.kind === kind);
  }
  // The same signs in the lists lead there, too.
  for (const sign of document.querySelectorAll("main [data-sign]")) {
    const mark = marks.find((own) => own.sign === sign.dataset.sign);
    if (!mark) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.className = sign.className;
    button.textContent = mark.sign;
    button.setAttribute("aria-label", `Show place ${mark.sign} in space`);
    button.addEventListener("click", () => {
      viewer.goTo(mark.at);
      place.scrollIntoView({ block: "center", behavior: "smooth" });
    });
    sign.replaceWith(button);
  }
}
