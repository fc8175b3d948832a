// Plays a push: the object as measured and as each model predicts it, and the pusher.
(() => {
  "use strict";
  const SVG = "http://www.w3.org/2000/svg";
  const PER_MM = 100;
  const PER_RADIAN = 1e4;

  function element(name, parent, classes = "") {
    const node = document.createElementNS(SVG, name);
    if (classes) node.setAttribute("class", classes);
    parent.append(node);
    return node;
  }

  // Numbers from the first one and the differences that follow.
  function sums(steps) {
    let sum = 0;
    return steps.map((step) => (sum += step));
  }

  const path = (xs, ys) => xs.map((x, k) => `${x},${ys[k]}`).join(" ");

  // A push in mm, degrees and s.
  function decoded(push) {
    const length = (steps) => sums(steps).map((value) => value / PER_MM);
    const turn = (steps) => sums(steps).map((value) => (value / PER_RADIAN) * (180 / Math.PI));
    const poses = ([x, y, angle]) => ({ x: length(x), y: length(y), angle: turn(angle) });
    return {
      outline: push.o,
      times: sums(push.t).map((value) => value / 1e3),
      measured: poses(push.m),
      pusher: { x: length(push.p[0]), y: length(push.p[1]) },
      models: push.r.map((predicted) => predicted && poses(predicted)),
      steps: { ...push.s, t: push.s.t.map((times) => sums(times).map((value) => value / 1e3)) },
    };
  }

  // The angle between -180° and 180°.
  const wrapped = (angle) => angle - 360 * Math.round(angle / 360);

  // The poses at a time; turns take the short way.
  function at(poses, times, time) {
    let next = times.findIndex((value) => value > time);
    if (next < 0) next = times.length - 1;
    const last = Math.max(next - 1, 0);
    const span = times[next] - times[last];
    const share = span > 0 ? Math.min((time - times[last]) / span, 1) : 1;
    const mix = (values) => values[last] + share * (values[next] - values[last]);
    const angle = poses.angle && poses.angle[last] + share * wrapped(poses.angle[next] - poses.angle[last]);
    return { x: mix(poses.x), y: mix(poses.y), angle, last };
  }

  // The rows of a file with the poses of a push at each time.
  function poseRows(data, push) {
    const names = ["measured", ...data.models.map((name) => name.split(" ")[0])];
    const columns = names.flatMap((name) => [`${name} x in mm`, `${name} y in mm`, `${name} angle in deg`]);
    const cells = (poses, k) => (poses ? [poses.x[k], poses.y[k], poses.angle[k].toFixed(4)] : ["", "", ""]);
    const row = (time, k) => [time, push.pusher.x[k], push.pusher.y[k], ...[push.measured, ...push.models].flatMap((poses) => cells(poses, k))];
    return [["time in s", "pusher x in mm", "pusher y in mm", ...columns], ...push.times.map(row)];
  }

  // The rows of a file with what was observed and predicted of each step.
  function stepRows(data, push) {
    const { t, c, v, e } = push.steps;
    const numbers = data.numbers.map((number, index) => ({ ...number, index })).filter((number) => number.shown !== "as");
    const label = ({ name, unit }) => (unit ? `${name} in ${unit}` : name);
    const tags = data.models.map((name) => name.split(" ")[0]);
    const columns = numbers.flatMap((number) => [label(number), ...tags.map((tag) => `${label(number)}, less that of ${tag}`)]);
    const value = (whole) => (whole === null ? "" : whole / 1e3);
    const row = (from, k) => [
      from, t[1][k], ...data.axes.map((axis, index) => axis.cells[c[index][k]]),
      ...numbers.flatMap(({ index }) => [value(v[index][k]), ...e.map((residuals) => value(residuals[index][k]))]),
    ];
    return [["from s", "to s", ...data.axes.map((axis) => axis.name), ...columns], ...t[0].map(row)];
  }

  function start(root) {
    const data = JSON.parse(root.querySelector("script").textContent);
    const find = (name) => root.querySelector(`[data-${name}]`);
    const [stage, choice, scrub, clock, rate, play] = ["stage", "pushes", "scrub", "clock", "rate", "play"].map(find);
    const rows = [...root.querySelectorAll("tr[class^=model]")];
    const outlines = data.outlines.map((steps) => {
      const flat = steps.length ? sums(steps) : [];
      return flat.map((value) => value / PER_MM);
    });
    let push, parts, time, end, frame, chosenRate;
    // The pushes that buttons and keys go through, if not all.
    let only = null;
    // Other scripts read the pushes from here.
    root.data = data;
    const tell = (name, detail) => root.dispatchEvent(new CustomEvent(name, { detail }));

    // Everything that moves, built once a push; y of the table points up.
    function build() {
      stage.replaceChildren();
      const world = element("g", stage);
      world.setAttribute("transform", "scale(1,-1)");
      const points = outlines[push.outline].reduce((all, value, k) => all + (k % 2 ? `,${value} ` : value), "");
      const body = (classes) => {
        const group = element("g", world, classes);
        element("polygon", group).setAttribute("points", points);
        element("path", group, "axis").setAttribute("d", "M0 0h10M0 0m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0");
        return group;
      };
      place(body("ghost"), at(push.measured, push.times, 0));
      element("polyline", world, "way").setAttribute("points", path(push.pusher.x, push.pusher.y));
      parts = { measured: body("measured"), models: push.models.map((poses, k) => poses && body(`model-${k % 6} dash-${k % 3}`)) };
      parts.trail = element("polyline", world, "trail measured");
      parts.trails = push.models.map((poses, k) => poses && element("polyline", world, `trail model-${k % 6} dash-${k % 3}`));
      parts.pusher = element("circle", world, "pusher");
      parts.pusher.setAttribute("r", data.radius / PER_MM);
      frameView();
    }

    // The view holds the object at every measured and predicted place.
    function frameView() {
      const outline = outlines[push.outline];
      let reach = 0;
      for (let k = 0; k < outline.length; k += 2) reach = Math.max(reach, Math.hypot(outline[k], outline[k + 1]));
      const all = [push.measured, ...push.models.filter(Boolean)];
      const range = (key) => {
        const values = all.flatMap((poses) => poses[key]);
        const tips = push.pusher[key];
        const r = data.radius / PER_MM + 2;
        return [Math.min(...values.map((v) => v - reach), ...tips.map((v) => v - r)), Math.max(...values.map((v) => v + reach), ...tips.map((v) => v + r))];
      };
      const [[left, right], [low, high]] = [range("x"), range("y")];
      const width = Math.max(right - left, 1.5 * (high - low)) + 12;
      const height = width / 1.5;
      const corner = [(left + right - width) / 2, -(low + high + height) / 2];
      stage.setAttribute("viewBox", [...corner, width, height].map((v) => v.toFixed(2)).join(" "));
      const bar = 10 ** Math.floor(Math.log10(width / 4));
      const long = [5, 2, 1].map((k) => k * bar).find((v) => v <= width / 4);
      const [x, y] = [corner[0] + 0.03 * width, corner[1] + height - 0.03 * width];
      element("path", stage, "scale").setAttribute("d", `M${x} ${y}h${long}`);
      const text = element("text", stage);
      const size = 13 * width / (stage.clientWidth || 640);
      for (const [name, value] of [["x", x], ["y", y - 0.4 * size], ["font-size", size]]) text.setAttribute(name, value.toFixed(2));
      text.textContent = `${long} mm`;
    }

    function place(group, pose) {
      group.setAttribute("transform", `translate(${pose.x.toFixed(3)} ${pose.y.toFixed(3)}) rotate(${pose.angle.toFixed(3)})`);
    }

    // The way of the origin up to now.
    function trace(line, poses, pose) {
      line.setAttribute("points", path([...poses.x.slice(0, pose.last + 1), pose.x], [...poses.y.slice(0, pose.last + 1), pose.y]));
    }

    const apart = (a, b) => {
      const turn = wrapped(b.angle - a.angle);
      return `${Math.hypot(b.x - a.x, b.y - a.y).toFixed(2)} mm, ${turn < 0 ? "−" : "+"}${Math.abs(turn).toFixed(2)}°`;
    };

    function draw() {
      const measured = at(push.measured, push.times, time);
      place(parts.measured, measured);
      trace(parts.trail, push.measured, measured);
      const pusher = at(push.pusher, push.times, time);
      parts.pusher.setAttribute("cx", pusher.x.toFixed(3));
      parts.pusher.setAttribute("cy", pusher.y.toFixed(3));
      push.models.forEach((poses, k) => {
        const cell = rows[k].querySelector("[data-now]");
        cell.textContent = poses ? "" : "no answer";
        if (!poses) return;
        const pose = at(poses, push.times, time);
        place(parts.models[k], pose);
        trace(parts.trails[k], poses, pose);
        cell.textContent = apart(measured, pose);
      });
      scrub.value = end > 0 ? Math.round((1000 * time) / end) : 1000;
      clock.textContent = `${time.toFixed(2)} of ${end.toFixed(2)} s`;
      scrub.setAttribute("aria-valuetext", clock.textContent);
      root.dataset.time = time.toFixed(3);
      tell("moved", { time });
    }

    function seek(to) {
      stop();
      time = Math.min(Math.max(to, 0), end);
      draw();
    }

    // A still shows the end, where the differences are.
    function select(index) {
      stop();
      choice.selectedIndex = index;
      push = decoded(data.pushes[index]);
      end = push.times[push.times.length - 1];
      time = end;
      rate.value = chosenRate ?? (end < 0.5 ? "0.1" : end < 2 ? "0.25" : "1");
      build();
      const last = (poses) => at(poses, push.times, end);
      const moved = apart(at(push.measured, push.times, 0), last(push.measured));
      find("moved").textContent = `moved ${moved}`;
      push.models.forEach((poses, k) => {
        rows[k].querySelector("[data-end]").textContent = poses ? apart(last(push.measured), last(poses)) : "no answer";
      });
      root.dataset.push = index;
      tell("shown", { index, data, steps: push.steps, time, end });
      draw();
    }

    // The next push, or the one before, of those that are gone through.
    function walk(by) {
      const among = only ?? data.pushes.map((_, index) => index);
      const place = among.indexOf(choice.selectedIndex);
      select(among[(Math.max(place, by > 0 ? -1 : 0) + by + among.length) % among.length]);
    }

    // From the end of a step to the next.
    function stepBy(by) {
      const { times } = push;
      const later = times.find((value) => value > time + 1e-6) ?? end;
      const earlier = times.findLast((value) => value < time - 1e-6) ?? 0;
      seek(by > 0 ? later : earlier);
    }

    function stop() {
      cancelAnimationFrame(frame);
      frame = undefined;
      play.textContent = "play";
      play.setAttribute("aria-pressed", "false");
      root.dataset.playing = "false";
    }

    function run() {
      if (time >= end) time = 0;
      let before;
      const tick = (now) => {
        time = Math.min(time + ((now - (before ?? now)) / 1e3) * Number(rate.value), end);
        before = now;
        draw();
        if (time < end) frame = requestAnimationFrame(tick);
        else stop();
      };
      play.textContent = "pause";
      play.setAttribute("aria-pressed", "true");
      root.dataset.playing = "true";
      frame = requestAnimationFrame(tick);
    }

    play.addEventListener("click", () => (frame === undefined ? run() : stop()));
    scrub.addEventListener("input", () => seek((scrub.value / 1000) * end));
    root.addEventListener("seek", ({ detail }) => seek(detail.time));
    root.addEventListener("only", ({ detail }) => (only = detail.pushes));
    choice.addEventListener("change", () => select(choice.selectedIndex));
    rate.addEventListener("change", () => (chosenRate = rate.value));
    for (const button of root.querySelectorAll("[data-step]")) {
      button.addEventListener("click", () => walk(Number(button.dataset.step)));
    }
    const keys = {
      " ": () => (frame === undefined ? run() : stop()),
      ArrowLeft: () => stepBy(-1),
      ArrowRight: () => stepBy(1),
      n: () => walk(1),
      p: () => walk(-1),
    };
    root.addEventListener("keydown", (event) => {
      const isPlain = !event.ctrlKey && !event.altKey && !event.metaKey;
      // What has keys of its own keeps them.
      const isOwn = event.target.closest("select") || (event.target.closest("button, input, a") && !/^[np]$/.test(event.key));
      if (!isPlain || isOwn || !keys[event.key]) return;
      event.preventDefault();
      keys[event.key]();
    });
    for (const button of root.querySelectorAll("[data-save]")) {
      button.addEventListener("click", () => {
        const name = `push-${choice.selectedIndex + 1}-${button.dataset.save}`;
        const rows = button.dataset.save === "poses" ? poseRows(data, push) : stepRows(data, push);
        document.dispatchEvent(new CustomEvent("save", { detail: { name, rows } }));
      });
    }
    window.addEventListener("beforeprint", () => {
      stop();
      time = end;
      draw();
    });

    // A link such as report.html#push-3 opens the third push, and #push-3-play plays it.
    function follow() {
      const wanted = /^#push-(\d+)(-play)?$/.exec(location.hash);
      if (!wanted) return;
      const index = Number(wanted[1]) - 1;
      select(index in data.pushes ? index : 0);
      root.scrollIntoView();
      root.focus({ preventScroll: true });
      if (wanted[2]) run();
    }

    if (data.pushes.length === 0) return;
    window.addEventListener("hashchange", follow);
    select(0);
    follow();
  }

  for (const root of document.querySelectorAll("[data-player]")) start(root);
})();
