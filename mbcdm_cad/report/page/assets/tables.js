// Parts of the page without 3D: light and dark style, the filter of the checks, the charts.
(function (page) {
  "use strict";

  page.listeners = [];

  function theme() {
    const button = document.getElementById("theme");
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const root = document.documentElement;
    const now = () => root.dataset.theme || (dark.matches ? "dark" : "light");
    const tell = () => {
      button.textContent = now() === "dark" ? "Light" : "Dark";
      for (const listener of page.listeners) listener();
    };
    button.addEventListener("click", () => {
      root.dataset.theme = now() === "dark" ? "light" : "dark";
      tell();
    });
    dark.addEventListener("change", tell);
    tell();
  }

  function checks() {
    const rows = [...document.querySelectorAll("#checks tbody tr")];
    const words = document.getElementById("check-words"), kinds = [...document.querySelectorAll("[data-check-kind]")];
    const count = document.getElementById("check-count");
    const filter = () => {
      const wanted = words.value.toLowerCase();
      const shownKinds = new Set(kinds.filter((box) => box.checked).map((box) => box.dataset.checkKind));
      let shown = 0;
      for (const row of rows) {
        const fits = shownKinds.has(row.dataset.status) && row.textContent.toLowerCase().includes(wanted);
        row.hidden = !fits;
        shown += fits ? 1 : 0;
      }
      count.textContent = `${shown} of ${rows.length} shown`;
    };
    for (const input of [words, ...kinds]) input.addEventListener("input", filter);
    filter();
  }

  theme();
  if (document.getElementById("checks")) checks();
  const graph = document.getElementById("graph");
  if (graph) page.graph(graph);
  for (const figure of document.querySelectorAll("figure.chart")) page.chart(figure);
})(window.drivePage);
