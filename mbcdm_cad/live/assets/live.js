// The page follows the design file: a bar tells what the last save came to, and a newer page takes this one's place
// without losing the view, the drum's angle or the place on the page.
"use strict";
(() => {
  const KEPT = "mbcdm-live-view";
  const bar = document.createElement("aside");
  bar.id = "live";
  bar.setAttribute("role", "status");
  bar.style.cssText =
    "position:fixed;left:0;right:0;bottom:0;z-index:50;max-height:40vh;overflow:auto;padding:.5em 1em;" +
    "font:14px/1.4 system-ui,sans-serif;color:#fff;background:#35506b";
  document.body.append(bar);
  document.body.style.paddingBottom = "3.5em";

  const COLOURS = { broken: "#8f1d1d", failing: "#8f1d1d", drawing: "#35506b", page: "#35506b", built: "#1e5c36" };
  const WORDS = {
    broken: "The file cannot be read; the last good state is shown.",
    failing: "Checks fail; the last good state is shown.",
    drawing: "Checks pass. Drawing what changed.",
    page: "Parts are drawn. Interference and the frame's stiffness are being worked out.",
    built: "Built.",
    stopped: "mbcdm watch has ended; this page stays as it is.",
  };

  function show(state) {
    const counts = state.counts.fail === undefined ? "" :
      ` ${state.counts.fail} fail, ${state.counts.warn} warn, ${state.counts.pass} pass.`;
    bar.style.background = COLOURS[state.stage] || "#555";
    bar.dataset.stage = state.stage;
    bar.dataset.save = String(state.save);
    bar.replaceChildren();
    const line = document.createElement("strong");
    line.textContent = `Save ${state.save}: ${WORDS[state.stage]}${counts}`;
    bar.append(line);
    const rows = state.findings.filter((row) => row.status === "fail");
    const texts = [state.message, ...rows.map((row) => `${row.id}: ${row.message}; ${row.remedy}`)].filter(Boolean);
    for (const text of texts) {
      const row = document.createElement("div");
      row.style.whiteSpace = "pre-wrap";
      row.textContent = text;
      bar.append(row);
    }
  }

  function viewer() {
    return window.drivePage && window.drivePage.viewer;
  }

  function keep() {
    const kept = { scroll: window.scrollY }, view = viewer();
    if (view) {
      kept.angle = view.angle;
      kept.camera = view.camera.position.toArray();
      kept.target = view.controls.target.toArray();
      kept.zoom = view.camera.zoom;
    }
    sessionStorage.setItem(KEPT, JSON.stringify(kept));
  }

  function restore() {
    const text = sessionStorage.getItem(KEPT);
    if (!text) return;
    sessionStorage.removeItem(KEPT);
    const kept = JSON.parse(text), until = performance.now() + 10000;
    window.scrollTo(0, kept.scroll);
    const wait = () => {
      const view = viewer();
      if (!view || !view.controls) {
        if (kept.camera && performance.now() < until) setTimeout(wait, 30);
        return;
      }
      if (!kept.camera) return;
      view.camera.position.fromArray(kept.camera);
      view.controls.target.fromArray(kept.target);
      view.camera.zoom = kept.zoom;
      view.camera.updateProjectionMatrix();
      view.controls.update();
      const slider = document.getElementById("angle");
      slider.value = String(kept.angle);
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    };
    wait();
  }

  restore();
  const events = new EventSource("events");
  events.onmessage = (event) => {
    const state = JSON.parse(event.data);
    show(state);
    if (state.page > window.liveDrive.page) {
      keep();
      location.reload();
    }
  };
  events.onerror = () => show({ save: bar.dataset.save || 0, stage: "stopped", counts: {}, findings: [], message: "" });
})();
