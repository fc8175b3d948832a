// Draws what was observed and predicted of each step of a push, over the time of the player.
(() => {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";
  const PER_UNIT = 1e3;
  const [WIDTH, HEIGHT] = [320, 124];
  const AREA = { left: 46, right: WIDTH - 8, top: 34, bottom: HEIGHT - 18 };

  function element(name, parent, attributes = {}, text = "") {
    const node = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.textContent = text;
    parent.append(node);
    return node;
  }

  const signed = (value) => `${value < 0 ? "−" : "+"}${Math.abs(value).toPrecision(2)}`;

  // About three round numbers between two ends.
  function ticks(low, high) {
    const least = (high - low) / 3;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 5, 10].map((k) => k * power).find((value) => value >= least);
    const first = Math.ceil(low / step);
    const n = Math.floor(high / step) - first + 1;
    return Array.from({ length: n }, (_, k) => ({ value: (first + k) * step, digits: Math.max(0, -Math.floor(Math.log10(step))) }));
  }

  // The lines of a number: one a model, and where it is told as it is, what was observed.
  function lines(data, steps, number, shown) {
    const observed = steps.v[number];
    const of = (residuals) => residuals[number].map((residual, k) => {
      if (residual === null) return null;
      return (shown === "error" ? residual : observed[k] - residual) / PER_UNIT;
    });
    const models = steps.e.map((residuals, model) => ({ name: data.models[model].split(" ")[0], classes: `model-${model % 6} dash-${model % 3}`, values: of(residuals) }));
    if (shown === "error") return models;
    const values = observed.map((value) => (value === null ? null : value / PER_UNIT));
    return [{ name: "measured", classes: "measured", values }, ...models];
  }

  function start(root) {
    const box = root.querySelector("[data-charts]");
    let charts = [];
    let marked = { steps: [], number: -1 };

    function chart({ number, key, name, unit, shown }, data, steps, end) {
      const all = lines(data, steps, number, shown);
      const known = all.flatMap(({ values }) => values.filter((value) => value !== null));
      if (known.length === 0) return;
      let [low, high] = [Math.min(0, ...known), Math.max(0, ...known)];
      const room = 0.08 * (high - low || 1e-3);
      [low, high] = [low - room, high + room];
      const x = (time) => AREA.left + ((AREA.right - AREA.left) * time) / Math.max(end, 1e-9);
      const y = (value) => AREA.bottom - ((AREA.bottom - AREA.top) * (value - low)) / (high - low);
      const svg = element("svg", box, { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "data-chart": key });
      const title = `${shown === "error" ? "error of " : ""}${name}${unit && ` in ${unit}`}`;
      svg.setAttribute("aria-label", `${title}, over the time of the push`);
      element("text", svg, { x: 4, y: 13, class: "title" }, title);
      const now = element("text", svg, { x: WIDTH - 4, y: 28, class: "now" });
      const [from, to] = steps.t;
      for (const step of marked.steps) {
        element("rect", svg, { class: "in", x: x(from[step]), y: AREA.top, width: x(to[step]) - x(from[step]), height: AREA.bottom - AREA.top });
      }
      for (const { value, digits } of ticks(low, high)) {
        element("path", svg, { class: value === 0 ? "zero" : "grid", d: `M${AREA.left} ${y(value)}H${AREA.right}` });
        element("text", svg, { x: AREA.left - 5, y: y(value) + 3.5, class: "tick" }, value.toFixed(digits).replace("-", "−"));
      }
      for (const { classes, values } of all) {
        let path = "";
        values.forEach((value, k) => {
          if (value === null) return;
          const goesOn = k > 0 && values[k - 1] !== null && Math.abs(to[k - 1] - from[k]) < 2e-3;
          path += `${goesOn ? "L" : "M"}${x(from[k]).toFixed(1)} ${y(value).toFixed(1)}H${x(to[k]).toFixed(1)}`;
        });
        element("path", element("g", svg, { class: classes }), { d: path });
      }
      const cursor = element("path", svg, { class: "cursor" });
      const seek = (event) => {
        const { left, width } = svg.getBoundingClientRect();
        const share = ((event.clientX - left) / width * WIDTH - AREA.left) / (AREA.right - AREA.left);
        root.dispatchEvent(new CustomEvent("seek", { detail: { time: Math.min(Math.max(share, 0), 1) * end } }));
      };
      svg.addEventListener("pointerdown", seek);
      svg.addEventListener("pointermove", (event) => event.buttons && seek(event));
      svg.classList.toggle("focus", number === marked.number);
      charts.push({
        move(time) {
          cursor.setAttribute("d", `M${x(time)} ${AREA.top}V${AREA.bottom}`);
          const step = from.findLastIndex((start) => start <= time + 1e-9);
          const told = all.filter(({ values }) => (values[step] ?? null) !== null);
          now.textContent = told.map(({ name, values }) => `${name} ${signed(values[step])}`).join("  ");
        },
      });
    }

    let shown = null;
    function build() {
      box.replaceChildren();
      charts = [];
      const { data, steps, end } = shown;
      data.numbers.forEach((about, number) => {
        if (about.shown !== "as") chart({ ...about, number }, data, steps, end);
      });
      charts.forEach((chart) => chart.move(shown.time));
    }

    root.addEventListener("shown", ({ detail }) => {
      shown = detail;
      marked = { steps: [], number: -1 };
      build();
    });
    root.addEventListener("moved", ({ detail }) => {
      if (shown) shown.time = detail.time;
      charts.forEach((chart) => chart.move(detail.time));
    });
    root.addEventListener("marked", ({ detail }) => {
      marked = detail;
      if (shown) build();
    });
  }

  for (const root of document.querySelectorAll("[data-player]")) start(root);
})();
