// The graph of the fields: choosing one shows all fields that it depends on and all that depend on it.
(function (page) {
  "use strict";

  page.graph = function (holder) {
    const nodes = new Map([...holder.querySelectorAll("g[data-field]")].map((node) => [node.dataset.field, node]));
    const lines = [...holder.querySelectorAll("path[data-from]")];
    const buttons = new Map([...document.querySelectorAll("[data-field-pick]")].map((b) => [b.dataset.fieldPick, b]));
    const told = document.getElementById("graph-shown");
    let picked = null;

    // Fields reached from one along the lines, with the lines passed; `ahead` follows them, else against them.
    const reached = (from, ahead) => {
      const fields = new Set(), passed = new Set(), waiting = [from];
      while (waiting.length) {
        const field = waiting.pop();
        for (const line of lines) {
          if ((ahead ? line.dataset.from : line.dataset.to) !== field) continue;
          const next = ahead ? line.dataset.to : line.dataset.from;
          passed.add(line);
          if (!fields.has(next)) waiting.push(next);
          fields.add(next);
        }
      }
      return { fields, passed };
    };
    const listed = (fields) => (fields.size ? [...fields].join(", ") : "nothing");

    const pick = (field) => {
      picked = field;
      const below = reached(field, false), above = reached(field, true);
      const near = new Set([field, ...below.fields, ...above.fields]);
      holder.classList.toggle("some", Boolean(field) && nodes.has(field));
      for (const [name, node] of nodes) {
        node.classList.toggle("near", near.has(name));
        node.classList.toggle("picked", name === field);
      }
      for (const line of lines) line.classList.toggle("near", below.passed.has(line) || above.passed.has(line));
      for (const [name, button] of buttons) button.setAttribute("aria-pressed", String(name === field));
      told.textContent = field
        ? `${field} depends on ${listed(below.fields)}. Depending on it: ${listed(above.fields)}.`
        : "";
      const box = nodes.get(field)?.getBBox();
      if (box) holder.scrollTo({ left: box.x - holder.clientWidth / 2 + box.width / 2, top: box.y - holder.clientHeight / 2 });
    };
    for (const [name, node] of nodes) node.addEventListener("click", () => pick(picked === name ? null : name));
    for (const [name, button] of buttons) button.addEventListener("click", () => pick(picked === name ? null : name));
  };
})((window.drivePage = window.drivePage || {}));
