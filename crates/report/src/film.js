// Shows drawings one after the other, as a film that is played, or gone through picture by picture.
(() => {
  "use strict";
  const PER_PICTURE = 400;
  for (const film of document.querySelectorAll("[data-film]")) {
    const pictures = [...film.querySelectorAll("figure")];
    const bar = document.createElement("div");
    bar.className = "controls";
    const button = document.createElement("button");
    const scrub = document.createElement("input");
    scrub.type = "range";
    scrub.min = 0;
    scrub.max = pictures.length - 1;
    scrub.setAttribute("aria-label", "picture of the film");
    bar.append(button, scrub);
    film.append(bar);
    let timer = null;
    const show = (index) => {
      pictures.forEach((picture, k) => (picture.hidden = k !== index));
      scrub.value = index;
      scrub.setAttribute("aria-valuetext", pictures[index].querySelector("figcaption").textContent);
    };
    const stop = () => {
      clearInterval(timer);
      timer = null;
      button.textContent = "play";
    };
    button.addEventListener("click", () => {
      if (timer) return stop();
      if (Number(scrub.value) === pictures.length - 1) show(0);
      button.textContent = "stop";
      timer = setInterval(() => {
        show(Number(scrub.value) + 1);
        if (Number(scrub.value) === pictures.length - 1) stop();
      }, PER_PICTURE);
    });
    scrub.addEventListener("input", () => {
      stop();
      show(Number(scrub.value));
    });
    stop();
    show(0);
  }
})();
