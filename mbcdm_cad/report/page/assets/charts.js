// Line charts that answer to the pointer and to the arrow keys. Each <figure class="chart"> holds its data as JSON.
(function (page) {
  "use strict";
  const NS = "http://www.w3.org/2000/svg";
  const DASHES = ["", "7 3", "2 3", "9 3 2 3", "4 2 1 2 1 2", "12 4"];
  const LEFT = 58, RIGHT = 14, TOP = 12, BOTTOM = 42;

  page.chart = function (figure) {
    const data = JSON.parse(figure.querySelector("script").textContent);
    const holder = figure.querySelector(".plot");
    const state = { at: null };
    const draw = () => drawn(holder, data, state);
    new ResizeObserver(draw).observe(holder);
    holder.addEventListener("pointermove", (event) => {
      const frame = holder.getBoundingClientRect();
      const { low, high, width } = state.scale;
      const share = (event.clientX - frame.left - LEFT) / (width - LEFT - RIGHT);
      mark(holder, data, state, low + Math.min(Math.max(share, 0), 1) * (high - low));
    });
    holder.addEventListener("pointerleave", () => mark(holder, data, state, null));
    holder.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const { low, high } = state.scale;
      const from = state.at === null ? (step > 0 ? low : high) : state.at + (step * (high - low)) / 40;
      mark(holder, data, state, Math.min(Math.max(from, low), high));
    });
    draw();
  };

  function drawn(holder, data, state) {
    const width = Math.max(260, holder.clientWidth), height = Math.round(Math.min(320, Math.max(220, width * 0.6)));
    const xs = data.lines.flatMap((line) => line.x), ys = data.lines.flatMap((line) => line.y);
    const low = Math.min(...xs), high = Math.max(...xs);
    const across = ticks(low, high, Math.max(3, Math.floor(width / 70)));
    const up = ticks(Math.min(0, ...ys), Math.max(...ys), 6);
    const bottom = Math.min(up[0], ...ys, 0), top = Math.max(up[up.length - 1], ...ys);
    const x = (v) => LEFT + ((v - low) / (high - low || 1)) * (width - LEFT - RIGHT);
    const y = (v) => height - BOTTOM - ((v - bottom) / (top - bottom || 1)) * (height - TOP - BOTTOM);
    state.scale = { low, high, width, height, x, y };
    const svg = element("svg", { width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
    for (const v of across) {
      svg.append(element("line", { class: "grid", x1: x(v), x2: x(v), y1: TOP, y2: height - BOTTOM }));
      svg.append(text(page.figure(v), { x: x(v), y: height - BOTTOM + 16, "text-anchor": "middle" }));
    }
    for (const v of up) {
      svg.append(element("line", { class: "grid", x1: LEFT, x2: width - RIGHT, y1: y(v), y2: y(v) }));
      svg.append(text(page.figure(v), { x: LEFT - 6, y: y(v) + 4, "text-anchor": "end" }));
    }
    const named = (axis) => (axis.unit ? `${axis.label} (${axis.unit})` : axis.label);
    const middle = (LEFT + width - RIGHT) / 2, half = (TOP + height - BOTTOM) / 2;
    svg.append(text(named(data.x), { class: "axis", x: middle, y: height - 6, "text-anchor": "middle" }));
    svg.append(text(named(data.y), {
      class: "axis", x: 0, y: 0, "text-anchor": "middle", transform: `translate(13 ${half}) rotate(-90)`,
    }));
    data.lines.forEach((line, k) => {
      const path = line.x.map((v, i) => `${i ? "L" : "M"}${x(v).toFixed(1)} ${y(line.y[i]).toFixed(1)}`).join("");
      svg.append(element("path", { class: "line", d: path, style: `stroke:var(--c${k % 6})`, "stroke-dasharray": DASHES[k % 6] }));
    });
    svg.append(element("g", { class: "marker" }));
    holder.querySelector("svg")?.remove();
    holder.prepend(svg);
    mark(holder, data, state, state.at);
  }

  function mark(holder, data, state, at) {
    state.at = at;
    const group = holder.querySelector(".marker"), label = holder.querySelector("output");
    group.replaceChildren();
    if (at === null) {
      label.textContent = "";
      return;
    }
    const { x, y, height } = state.scale;
    group.append(element("line", { class: "cursor", x1: x(at), x2: x(at), y1: TOP, y2: height - BOTTOM }));
    const read = data.lines.map((line, k) => {
      const value = valueAt(line, at);
      if (value === null) return null;
      group.append(element("circle", { cx: x(at), cy: y(value), r: 3.5, style: `fill:var(--c${k % 6})` }));
      return `${line.label}: ${page.figure(value)}`;
    });
    const unit = (axis) => (axis.unit && axis.unit !== "-" ? ` ${axis.unit}` : "");
    label.textContent = `${data.x.label} ${page.figure(at)}${unit(data.x)} → ${read.filter(Boolean).join("; ")}${unit(data.y)}`;
  }

  // Where a line passes a place more than once, the first passage counts.
  function valueAt(line, at) {
    for (let i = 0; i + 1 < line.x.length; i += 1) {
      const [a, b] = [line.x[i], line.x[i + 1]];
      if ((a <= at && at <= b) || (b <= at && at <= a))
        return line.y[i] + (b === a ? 0 : ((at - a) / (b - a)) * (line.y[i + 1] - line.y[i]));
    }
    return null;
  }

  function ticks(low, high, count) {
    const raw = (high - low) / count || 1, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw * 0.999);
    const found = [];
    for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + step * 1e-6; v += step) found.push(Math.abs(v) < step * 1e-6 ? 0 : v);
    return found;
  }

  page.figure = function (value) {
    if (value === 0) return "0";
    const text = Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toPrecision(3) : String(Number(value.toPrecision(4)));
    return text.replace("-", "−");
  };

  function element(name, attributes) {
    const node = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return node;
  }

  function text(content, attributes) {
    const node = element("text", attributes);
    node.textContent = content;
    return node;
  }
})((window.drivePage = window.drivePage || {}));
