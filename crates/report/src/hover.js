// Shows the texts of a drawing's parts under the pointer, a finger or the arrow keys.
(() => {
  "use strict";
  const drawings = document.querySelectorAll(".live");
  const box = document.createElement("div");
  box.className = "tip";
  box.setAttribute("role", "status");
  document.body.append(box);
  let shown = null;

  function hide() {
    shown?.classList.remove("on");
    shown = null;
    box.classList.remove("on");
  }

  // The text stands above the point, inside the window.
  function show(spot, x, y) {
    if (spot !== shown) {
      hide();
      shown = spot;
      spot.classList.add("on");
      box.textContent = spot.dataset.text;
      box.classList.add("on");
    }
    const { width, height } = box.getBoundingClientRect();
    const left = Math.min(Math.max(x - width / 2, 4), document.documentElement.clientWidth - width - 4);
    const above = y - height - 12;
    box.style.left = `${left}px`;
    box.style.top = `${above < 4 ? y + 18 : above}px`;
  }

  const center = (spot) => {
    const { left, top, width, height } = spot.getBoundingClientRect();
    return [left + width / 2, top + height / 2];
  };

  // The nearest spot in the direction of an arrow key; sideways counts twice.
  function next(spots, [dx, dy]) {
    if (!shown || !spots.includes(shown)) return spots[0];
    const [x, y] = center(shown);
    let best = shown;
    let least = Infinity;
    for (const spot of spots) {
      const [u, v] = center(spot);
      const along = (u - x) * dx + (v - y) * dy;
      const aside = Math.abs((u - x) * dy - (v - y) * dx);
      if (spot !== shown && along > 0.5 && along + 2 * aside < least) {
        best = spot;
        least = along + 2 * aside;
      }
    }
    return best;
  }

  const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

  for (const drawing of drawings) {
    const spots = [...drawing.querySelectorAll(".spot")];
    if (spots.length === 0) continue;
    for (const spot of spots) {
      // Taken out, so that the browser does not show it a second time.
      const title = spot.querySelector("title");
      spot.dataset.text = title.textContent;
      title.remove();
    }
    drawing.querySelector("svg > title")?.remove();
    const point = (event) => {
      const spot = event.target.closest(".spot");
      if (spot) show(spot, event.clientX, event.clientY);
      else hide();
    };
    drawing.addEventListener("pointermove", point);
    drawing.addEventListener("pointerdown", point);
    drawing.addEventListener("pointerleave", (event) => event.pointerType === "mouse" && hide());
    drawing.addEventListener("blur", hide);
    // A cell that leads to its steps is chosen by a click, or by the enter key.
    const choose = (spot) => spot?.dispatchEvent(new CustomEvent("choose", { bubbles: true }));
    drawing.addEventListener("click", (event) => choose(event.target.closest("[data-cell]")));
    drawing.addEventListener("keydown", (event) => {
      if (event.key === "Escape") return hide();
      if (event.key === "Enter" && spots.includes(shown)) return choose(shown.closest("[data-cell]"));
      const direction = ARROWS[event.key];
      if (!direction) return;
      event.preventDefault();
      const spot = next(spots, direction);
      show(spot, ...center(spot));
    });
  }
  window.addEventListener("scroll", hide, { passive: true });
})();
