// Lays two drawings of one size over each other, behind a slider from the one to the other.
(() => {
  "use strict";
  for (const pair of document.querySelectorAll("[data-pair]")) {
    const figures = [...pair.querySelectorAll("figure")];
    const [before, after] = figures.map((figure) => figure.querySelector(".live"));
    const [left, right] = figures.map((figure) => figure.querySelector("figcaption"));
    const stack = document.createElement("div");
    stack.className = "stack";
    before.replaceWith(stack);
    stack.append(before, after);
    figures[0].append(right);
    figures[1].hidden = true;
    const slider = document.createElement("input");
    slider.type = "range";
    slider.min = 0;
    slider.max = 100;
    slider.value = 50;
    const cut = () => {
      stack.style.setProperty("--cut", `${slider.value}%`);
      slider.setAttribute("aria-valuetext", `${slider.value} % of the width: ${left.firstChild.textContent}; the rest: ${right.firstChild.textContent}`);
    };
    slider.setAttribute("aria-label", "how much of the first drawing is seen, from the left");
    slider.addEventListener("input", cut);
    stack.after(slider);
    pair.classList.add("on");
    cut();
  }
})();
