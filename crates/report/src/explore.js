// Leads from a finding, or a cell of a map, to its pushes and their steps in the player, and back.
(() => {
  "use strict";
  const player = document.querySelector("[data-player]");
  if (!player?.data?.pushes.length) return;
  const MOST_LISTED = 60;
  const { data } = player;
  const names = [...player.querySelectorAll("[data-pushes] option")].map((option) => option.textContent.split(" · ")[0]);
  const maps = [...document.querySelectorAll(".live[data-number]")];
  const links = [...document.querySelectorAll("a[data-in]")];
  const [line, where, told] = ["chosen", "where", "told"].map((name) => player.querySelector(`[data-${name}]`));
  const panel = document.createElement("aside");
  panel.className = "region";
  panel.tabIndex = -1;
  panel.setAttribute("aria-label", "steps that were chosen");
  let region = null;
  // The drawing in which a cell was chosen, and the push that is shown.
  let chosenIn = null;
  let shown = { index: Number(player.dataset.push), time: Number(player.dataset.time) };

  const tag = (model) => data.models[model].split(" ")[0];
  const address = (key) => `#in/${key}`;

  // A node with text, attributes and children.
  function node(name, attributes, ...children) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    made.append(...children);
    return made;
  }

  // A key such as `0/turn/p=0,1/beta=5`: a model, a number, and cells of axes; null for any other text.
  function parse(key) {
    const [model, name, ...parts] = key.split("/");
    const number = data.numbers.findIndex((known) => known.key === name);
    const cells = parts.map((part) => {
      const [axis, list = ""] = part.split("=");
      return { axis: data.axes.findIndex((known) => known.key === axis), cells: list.split(",").map(Number) };
    });
    const isKnown = model in data.models && number >= 0 && cells.every(({ axis, cells }) => axis >= 0 && cells.every((cell) => cell in data.axes[axis].cells));
    return isKnown ? { key, model: Number(model), number, cells } : null;
  }

  const keyOf = (map, cell) => {
    const over = map.dataset.over.split(" ");
    const cells = cell.split(".").map((index, k) => `/${over[k]}=${index}`);
    return `${map.dataset.models.split(" ")[0]}/${map.dataset.number}${cells.join("")}`;
  };

  // The steps of a push in a region.
  function stepsIn({ model, number, cells }, { s }) {
    const isIn = (step) => cells.every(({ axis, cells }) => cells.includes(s.c[axis][step]));
    return [...s.e[model][number].keys()].filter((step) => s.e[model][number][step] !== null && isIn(step));
  }

  // The pushes of a region, those first whose steps are missed most in the sense of all.
  function pushesIn(region) {
    const { model, number } = region;
    const all = data.pushes.map((push, index) => {
      const steps = stepsIn(region, push);
      const sum = steps.reduce((sum, step) => sum + push.s.e[model][number][step] / 1e3, 0);
      return { index, steps, sum, mean: sum / steps.length };
    });
    const found = all.filter(({ steps }) => steps.length > 0);
    const n = found.reduce((n, { steps }) => n + steps.length, 0);
    const mean = found.reduce((sum, push) => sum + push.sum, 0) / n;
    found.sort((a, b) => (b.mean - a.mean) * Math.sign(mean || 1));
    return { found, n, mean };
  }

  const size = (value, { unit }) => `${value < 0 ? "−" : "+"}${Math.abs(value).toPrecision(3)}${unit === "°" ? "" : " "}${unit}`;

  // `turn Δθ of A, p 0 to 0.4, β 15 to 30°`
  function described({ model, number, cells }) {
    const range = ({ axis, cells }) => {
      const { short, unit, cells: told } = data.axes[axis];
      const [first, last] = [told[cells[0]], told[cells[cells.length - 1]]];
      const [from, to] = [first.split(" to ")[0], last.split(" to ").pop()];
      return `${short} ${from === to ? from : `${from} to ${to}`}${unit}`;
    };
    return [`${data.numbers[number].name} of ${tag(model)}`, ...cells.map(range)].join(", ");
  }

  // Whether a cell of a map lies in a region.
  function isInside({ model, number, cells }, map, cell) {
    const { models, number: name, over } = map.dataset;
    if (name !== data.numbers[number].key || !models.split(" ").includes(String(model))) return false;
    const index = cell.split(".").map(Number);
    return over.split(" ").every((key, k) => cells.find(({ axis }) => data.axes[axis].key === key)?.cells.includes(index[k]));
  }

  // Marks the cells of a region on every map, and answers with the one that shows most of it.
  function mark(region) {
    let best = null;
    for (const map of maps) {
      let n = 0;
      for (const spot of map.querySelectorAll("[data-cell]")) {
        const isChosen = region !== null && isInside(region, map, spot.dataset.cell);
        spot.classList.toggle("chosen", isChosen);
        n += isChosen;
      }
      const rank = n > 0 ? map.dataset.over.split(" ").length + (map.id ? 0.5 : 0) : 0;
      if (rank > (best?.rank ?? 0)) best = { map, rank };
    }
    return best?.map ?? null;
  }

  function list({ found, n, mean }) {
    const about = data.numbers[region.number];
    const heading = node("p", {}, node("strong", {}, described(region)), `: ${n} steps of ${found.length} pushes`);
    if (n > 0) heading.append(`, mean ${size(mean, about)}`);
    if (names.length < data.all) heading.append(`, of the ${names.length} of ${data.all} pushes that are on this page`);
    const pushes = found.slice(0, MOST_LISTED).map(({ index, mean }) => node("li", {}, node("a", { href: `#push-${index + 1}` }, names[index]), ` ${size(mean, about)}`));
    const more = found.length > MOST_LISTED ? [node("li", {}, `and ${found.length - MOST_LISTED} more, with n in the player`)] : [];
    const close = node("button", { type: "button", class: "csv" }, "close");
    close.addEventListener("click", leave);
    panel.replaceChildren(heading, node("ul", {}, ...pushes, ...more), node("p", { class: "controls" }, ...backLinks(), close));
  }

  // To the findings that the region is a part of.
  function backLinks() {
    const isPart = (link) => {
      const found = parse(link.dataset.in);
      if (found?.model !== region.model || found.number !== region.number) return false;
      return found.cells.every(({ axis, cells }) => region.cells.find((own) => own.axis === axis)?.cells.every((cell) => cells.includes(cell)));
    };
    return links.filter(isPart).map((link) => node("a", { href: `#${link.closest("li").id}` }, "back to the finding"));
  }

  function choose(next, from) {
    region = next;
    const map = mark(region);
    const place = from ?? map;
    const found = pushesIn(region);
    list(found);
    const link = links.find((link) => link.dataset.in === region.key);
    const before = place ? place.closest("[data-pair], figure") : link?.closest("ul");
    const folded = before?.closest("details");
    if (folded) folded.open = true;
    if (before) before.after(panel);
    else player.before(panel);
    tellPlayer(found);
    if (from) panel.scrollIntoView({ block: "nearest" });
    else (before ?? panel).scrollIntoView();
    panel.focus({ preventScroll: true });
  }

  // Back to the map as it was before.
  function leave() {
    const map = panel.previousElementSibling?.querySelector(".live[tabindex]");
    region = null;
    mark(null);
    panel.remove();
    tellPlayer(null);
    map?.focus();
  }

  function tellPlayer(found) {
    const pushes = found?.found.map(({ index }) => index) ?? null;
    player.dispatchEvent(new CustomEvent("only", { detail: { pushes } }));
    line.hidden = region === null;
    if (region === null) return markSteps();
    const back = node("a", { href: address(region.key) }, "back to the map");
    back.addEventListener("click", (event) => {
      event.preventDefault();
      go(region.key);
    });
    const all = node("button", { type: "button", class: "csv" }, "all pushes");
    all.addEventListener("click", leave);
    const count = node("span", { "data-count": "" });
    line.replaceChildren(node("span", {}, `Chosen: ${described(region)}`, count), " ", back, " ", all);
    line.dataset.pushes = pushes.join(" ");
    markSteps();
  }

  // The steps of the push that are in the region, and which of its pushes it is.
  function markSteps() {
    const steps = region ? stepsIn(region, data.pushes[shown.index]) : [];
    const about = region && data.numbers[region.number];
    const number = about ? about.of ?? region.number : -1;
    player.dispatchEvent(new CustomEvent("marked", { detail: { steps, number } }));
    const count = line.querySelector("[data-count]");
    if (!region || !count) return;
    const among = line.dataset.pushes.split(" ").map(Number);
    const place = among.indexOf(shown.index);
    count.textContent = place < 0 ? "; this push is not of it." : `; push ${place + 1} of ${among.length}.`;
  }

  // The findings that tell of the push.
  function tellFindings() {
    const push = data.pushes[shown.index];
    const of = links.filter((link) => {
      const found = parse(link.dataset.in);
      return found && found.cells.length > 0 && stepsIn(found, push).length > 0;
    });
    const items = of.map((link) => {
      const item = link.closest("li");
      const of = `${tag(parse(link.dataset.in).model)}: `;
      return node("li", {}, of, node("a", { href: `#${item.id}` }, item.firstChild.textContent.trim()));
    });
    told.replaceChildren(...(items.length ? [node("p", {}, "What is told of places that this push went through:"), node("ul", {}, ...items)] : []));
  }

  // Links to the cells that the step is in, where maps have them.
  let step = -1;
  function tellWhere() {
    const { s } = data.pushes[shown.index];
    const ends = s.t[1].reduce((ends, value) => [...ends, (ends[ends.length - 1] ?? 0) + value], []);
    const next = ends.findIndex((end) => end / 1e3 >= shown.time - 1e-6);
    const now = next < 0 ? ends.length - 1 : next;
    if (now === step) return;
    step = now;
    const cells = maps.filter((map) => map.id && map.dataset.over.includes(" ")).flatMap((map) => {
      const axes = map.dataset.over.split(" ").map((key) => data.axes.findIndex((axis) => axis.key === key));
      const cell = axes.map((axis) => s.c[axis]?.[step]).join(".");
      const number = data.numbers.find((known) => known.key === map.dataset.number);
      if (!number || !map.querySelector(`[data-cell="${cell}"]`)) return [];
      const over = axes.map((axis) => data.axes[axis].short).join(" and ");
      return [{ map, cell, what: `${number.name} over ${over}` }];
    });
    // One item a map of all models.
    const items = [...new Set(cells.map(({ what }) => what))].map((what) => {
      const links = cells.filter((one) => one.what === what).map(({ map, cell }) => node("a", { href: address(keyOf(map, cell)) }, tag(map.dataset.models.split(" ")[0])));
      return node("span", {}, `; ${what}: `, ...links.flatMap((link) => [link, " "]));
    });
    where.replaceChildren(`Step ${step + 1} of ${ends.length}${items.length ? ". Its cells on the maps" : ""}`, ...items);
  }

  function follow() {
    if (!location.hash.startsWith("#in/")) return;
    const next = parse(decodeURIComponent(location.hash.slice(4)));
    if (next) choose(next, chosenIn);
    chosenIn = null;
  }

  // Goes to an address, also to the one where the page is.
  function go(key) {
    if (location.hash === address(key)) follow();
    else location.hash = address(key);
  }

  links.forEach((link, index) => {
    link.closest("li").id = `finding-${index + 1}`;
    link.addEventListener("click", (event) => {
      event.preventDefault();
      go(link.dataset.in);
    });
  });
  document.addEventListener("choose", ({ target }) => {
    const map = target.closest(".live[data-number]");
    if (!map) return;
    chosenIn = map;
    go(keyOf(map, target.dataset.cell));
  });
  panel.addEventListener("keydown", (event) => event.key === "Escape" && leave());
  player.addEventListener("keydown", (event) => event.key === "Escape" && region && go(region.key));
  player.addEventListener("shown", ({ detail }) => {
    shown = { index: detail.index, time: detail.time };
    step = -1;
    markSteps();
    tellFindings();
  });
  player.addEventListener("moved", ({ detail }) => {
    shown.time = detail.time;
    tellWhere();
  });
  window.addEventListener("hashchange", follow);
  markSteps();
  tellFindings();
  tellWhere();
  follow();
})();
