// Connects the 3D view with its controls: sliders, list of parts, data of the picked part, steps of assembly.
(function (page) {
  "use strict";
  const byId = (id) => document.getElementById(id);
  const MINUS = (text) => String(text).replace("-", "−");

  function start() {
    const data = JSON.parse(byId("scene").textContent);
    let viewer;
    try {
      viewer = new page.Viewer(byId("canvas"), data, page.bytesOf(byId("binary").textContent));
    } catch (error) {
      byId("view").classList.add("no-picture");
      byId("no-picture").hidden = false;
      console.warn(`no 3D picture: ${error.message}`);
      return;
    }
    page.viewer = viewer;
    const sync = () => viewer.lineColour(getComputedStyle(document.documentElement).getPropertyValue("--edge").trim());
    page.listeners.push(sync);
    sync();
    motion(viewer, data);
    sections(viewer, data);
    apart(viewer);
    views(viewer);
    const list = parts(viewer, data);
    const rows = [...document.querySelectorAll("#assembly li[data-step]")];
    steps(viewer, rows, list);
    page.stepPictures(viewer, rows);
    keys(viewer);
    document.documentElement.dataset.ready = "yes";
  }

  function motion(viewer, data) {
    const slider = byId("angle"), shown = byId("angle-shown"), play = byId("play");
    const cells = new Map([...document.querySelectorAll("[data-body-angle]")].map((c) => [c.dataset.bodyAngle, c]));
    slider.addEventListener("input", () => viewer.pose(Number(slider.value)));
    viewer.on("posed", (angle) => {
      slider.value = angle;
      // The slider counts from the middle of the travel, the output from its own zero.
      const output = (angle + data.middle_deg).toFixed(1);
      shown.textContent = `${MINUS(output)}°`;
      slider.setAttribute("aria-valuetext", `${output} degrees`);
      for (const body of data.bodies) {
        const cell = cells.get(body.name);
        if (cell) cell.textContent = `${MINUS((body.ratio * angle).toFixed(1))}°`;
      }
    });
    let running = null;
    const stop = () => {
      cancelAnimationFrame(running);
      running = null;
      play.textContent = "Play";
      play.setAttribute("aria-pressed", "false");
    };
    const run = () => {
      const half = data.half_travel_deg, began = performance.now();
      const from = Math.asin(Math.min(Math.max(viewer.angle / half, -1), 1));
      play.textContent = "Stop";
      play.setAttribute("aria-pressed", "true");
      const step = (now) => {
        viewer.pose(half * Math.sin(from + (now - began) / 1400));
        running = requestAnimationFrame(step);
      };
      running = requestAnimationFrame(step);
    };
    play.addEventListener("click", () => (running === null ? run() : stop()));
    slider.addEventListener("pointerdown", stop);
    byId("centre").addEventListener("click", () => {
      stop();
      viewer.pose(0);
    });
    viewer.pose(viewer.angle);
  }

  function sections(viewer) {
    const place = byId("cut"), shown = byId("cut-shown"), flip = byId("flip");
    const axes = [...document.querySelectorAll("input[name=cut-axis]")];
    const box = new THREE.Box3();
    for (const entry of viewer.entries) if (entry.box) box.union(entry.box);
    const chosen = () => axes.find((input) => input.checked).value;
    const apply = () => {
      const axis = chosen();
      place.disabled = flip.disabled = !axis;
      shown.textContent = axis ? `${axis.toUpperCase()} = ${MINUS(Number(place.value).toFixed(1))} mm` : "off";
      viewer.cut(axis, Number(place.value), flip.checked);
    };
    for (const input of axes)
      input.addEventListener("change", () => {
        const axis = chosen();
        if (axis) {
          place.min = Math.floor(box.min[axis]);
          place.max = Math.ceil(box.max[axis]);
          place.value = Math.min(Math.max(0, place.min), place.max);
        }
        apply();
      });
    for (const input of [place, flip]) input.addEventListener("input", apply);
  }

  function apart(viewer) {
    const slider = byId("explode"), shown = byId("explode-shown");
    slider.addEventListener("input", () => {
      viewer.explode(Number(slider.value) / 100);
      shown.textContent = `${slider.value} %`;
    });
  }

  function views(viewer) {
    for (const button of document.querySelectorAll("[data-view]"))
      button.addEventListener("click", () => viewer.look(button.dataset.view));
    byId("fit").addEventListener("click", () => viewer.fit());
    byId("fullscreen").addEventListener("click", () => {
      if (document.fullscreenElement) document.exitFullscreen();
      else byId("stage").requestFullscreen?.();
    });
  }

  // The list of parts: a check box to hide each, a button to pick it. Returns functions that update the list.
  function parts(viewer) {
    const boxes = new Map([...document.querySelectorAll("[data-show]")].map((box) => [box.dataset.show, box]));
    const buttons = new Map([...document.querySelectorAll("[data-pick]")].map((b) => [b.dataset.pick, b]));
    const groups = [...document.querySelectorAll("[data-show-group]")];
    const members = (group) => [...group.closest("details").querySelectorAll("[data-show]")];
    const facts = byId("facts"), none = byId("facts-none");
    let picked = null;

    const sync = () => {
      for (const [name, box] of boxes) box.checked = viewer.entry(name).shown;
      for (const group of groups) {
        const shown = members(group).filter((box) => box.checked).length;
        group.checked = shown > 0;
        group.indeterminate = shown > 0 && shown < members(group).length;
      }
    };
    const pick = (name) => {
      picked = name;
      for (const [each, button] of buttons) button.setAttribute("aria-pressed", String(each === name));
      viewer.select(name ? [name] : []);
      facts.hidden = !name;
      none.hidden = Boolean(name);
      if (!name) return;
      const button = buttons.get(name), row = button.closest("details");
      row.open = true;
      const list = byId("list"), top = button.getBoundingClientRect().top - list.getBoundingClientRect().top;
      if (top < 0 || top > list.clientHeight - 30) list.scrollTop += top - list.clientHeight / 2;
      const entry = viewer.entry(name), body = entry.body ? viewer.bodies.get(entry.body) : null;
      byId("fact-name").textContent = name;
      byId("fact-part").textContent = entry.part;
      byId("fact-material").textContent = `${entry.material}, ${entry.kind}`;
      byId("fact-mass").textContent = `${page.figure(entry.mass_g)} g`;
      byId("fact-body").textContent = body
        ? body.ratio === 0 ? "does not move" : `turns with ${body.name}, ${MINUS(body.ratio)} × the drum`
        : "winds along its route";
      const files = byId("fact-files");
      files.replaceChildren();
      const template = document.querySelector(`template[data-files="${CSS.escape(entry.part)}"]`);
      if (template) files.append(template.content.cloneNode(true));
    };

    for (const [name, box] of boxes)
      box.addEventListener("change", () => {
        viewer.show([name], box.checked);
        sync();
      });
    for (const group of groups)
      group.addEventListener("change", () => {
        viewer.show(members(group).map((box) => box.dataset.show), group.checked);
        sync();
      });
    for (const [name, button] of buttons) button.addEventListener("click", () => pick(picked === name ? null : name));
    viewer.on("picked", (entry) => pick(entry ? entry.name : null));
    const act = (id, action) =>
      byId(id).addEventListener("click", () => {
        action();
        sync();
      });
    act("show-all", () => viewer.show([...boxes.keys()], true));
    act("hide-picked", () => {
      if (picked) viewer.show([picked], false);
    });
    act("only-picked", () => {
      if (picked) viewer.showOnly([picked]);
    });
    act("zoom-picked", () => {
      if (picked) viewer.fit([picked]);
    });
    pick(null);
    return { sync, pick };
  }

  function steps(viewer, all, list) {
    const joined = all.map((row) => JSON.parse(row.dataset.items));
    const show = (index) => {
      const present = joined.slice(0, index + 1).flat();
      viewer.showOnly(present);
      list.pick(null);
      viewer.select(joined[index]);
      list.sync();
      viewer.fit();
      all.forEach((row, k) => row.classList.toggle("current", k === index));
      byId("step-shown").textContent = `Step ${index + 1} of ${all.length}`;
      byId("stage").scrollIntoView({ block: "start", behavior: "smooth" });
    };
    for (const button of document.querySelectorAll("[data-show-step]"))
      button.addEventListener("click", () => show(Number(button.dataset.showStep)));
    byId("show-all").addEventListener("click", () => {
      all.forEach((row) => row.classList.remove("current"));
      byId("step-shown").textContent = "";
      viewer.select([]);
    });
  }

  function keys(viewer) {
    byId("canvas").addEventListener("keydown", (event) => {
      const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
      if (turn) viewer.turn(...turn);
      else if (event.key === "+" || event.key === "=") viewer.zoom(1.15);
      else if (event.key === "-") viewer.zoom(1 / 1.15);
      else if (event.key === "0" || event.key === "f") viewer.fit();
      else if (event.key === "[") viewer.pose(viewer.angle - 1);
      else if (event.key === "]") viewer.pose(viewer.angle + 1);
      else return;
      event.preventDefault();
    });
  }

  // The tables are shown first; the picture follows after they are painted.
  requestAnimationFrame(() => setTimeout(start, 0));
})(window.drivePage);
