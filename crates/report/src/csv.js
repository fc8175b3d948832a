// Saves a table, or the numbers behind a drawing, as CSV.
(() => {
  "use strict";

  function save(name, text) {
    const link = document.createElement("a");
    link.download = `${name}.csv`;
    link.href = URL.createObjectURL(new Blob([text], { type: "text/csv;charset=utf-8" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1e4);
  }

  const quoted = (text) => (/[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

  // A true minus is none to programs that read numbers.
  const line = (cells) => `${cells.map((cell) => quoted(String(cell ?? "").trim().replaceAll("−", "-"))).join(",")}\n`;

  const tableText = (table) => [...table.rows].map((row) => line([...row.cells].map((cell) => cell.textContent))).join("");

  // The section's name and a number tell files apart.
  const counts = new Map();
  function named(node, kind) {
    const section = node.closest("section")?.id ?? "page";
    const key = `${section}-${kind}`;
    counts.set(key, (counts.get(key) ?? 0) + 1);
    return `${key}-${counts.get(key)}`;
  }

  function button(name, text) {
    const node = document.createElement("button");
    node.type = "button";
    node.className = "csv";
    node.textContent = "CSV";
    node.setAttribute("aria-label", `save as ${name}.csv`);
    node.dataset.name = name;
    node.addEventListener("click", () => save(name, text()));
    return node;
  }

  for (const scroll of document.querySelectorAll("section .scroll")) {
    if (scroll.closest("[data-player]")) continue;
    scroll.after(button(named(scroll, "table"), () => tableText(scroll.querySelector("table"))));
  }
  for (const numbers of document.querySelectorAll("pre[data-csv]")) {
    const figure = numbers.closest("figure");
    const name = figure.querySelector(".live[id]")?.id ?? named(figure, "drawing");
    figure.querySelector("figcaption").append(button(name, () => numbers.textContent));
  }
  // Other parts of the page ask for it with an event.
  document.addEventListener("save", ({ detail }) => save(detail.name, detail.rows.map(line).join("")));
})();
