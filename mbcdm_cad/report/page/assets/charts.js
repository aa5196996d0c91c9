// Line charts that respond to the pointer and to the arrow keys. Each <figure class="chart"> contains its data as JSON.
(function (page) {
  "use strict";
  const NS = "http://www.w3.org/2000/svg";
  const DASHES = ["", "7 3", "2 3", "9 3 2 3", "4 2 1 2 1 2", "12 4"];
  const LEFT = 58, RIGHT = 14, TOP = 12, BOTTOM = 42;
  const LOG_SPAN = 1e-4; // a logarithmic axis shows four decades below its top

  page.chart = function (figure) {
    const data = JSON.parse(figure.querySelector("script").textContent);
    const holder = figure.querySelector(".plot");
    const state = { at: null };
    const draw = () => drawn(holder, data, state);
    new ResizeObserver(draw).observe(holder);
    holder.addEventListener("pointermove", (event) => {
      const frame = holder.getBoundingClientRect();
      const { low, high, width, back } = state.scale;
      const share = (event.clientX - frame.left - LEFT) / (width - LEFT - RIGHT);
      mark(holder, data, state, back(low + Math.min(Math.max(share, 0), 1) * (high - low)));
    });
    holder.addEventListener("pointerleave", () => mark(holder, data, state, null));
    holder.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const { low, high, along, back } = state.scale;
      const from = state.at === null ? (step > 0 ? low : high) : along(state.at) + (step * (high - low)) / 40;
      mark(holder, data, state, back(Math.min(Math.max(from, low), high)));
    });
    draw();
  };

  // An axis: `log` axes are laid out by the logarithm. Null in a line is a gap.
  const along = (axis) => (axis.log ? Math.log10 : (v) => v);
  const colour = (line, k) => `var(--c${line.colour ?? k % 6})`;
  const dashes = (line, k) => (line.colour === undefined ? DASHES[k % 6] : "");

  function drawn(holder, data, state) {
    const width = Math.max(260, holder.clientWidth), height = Math.round(Math.min(320, Math.max(220, width * 0.6)));
    const fx = along(data.x), fy = along(data.y);
    const xs = range(data.lines.map((line) => line.x)), ys = range(data.lines.map((line) => line.y));
    xs.low = data.x.from ?? xs.low;
    const low = fx(xs.low), high = fx(xs.high);
    const across = data.x.log ? decades(xs) : ticks(low, high, Math.max(3, Math.floor(width / 70)));
    const shown = data.y.log ? { low: Math.max(ys.low, ys.high * LOG_SPAN), high: ys.high } : ys;
    const up = data.y.log ? decades(shown) : ticks(Math.min(0, ys.low), ys.high, 6);
    const bottom = data.y.log ? fy(shown.low) : Math.min(up[0], ys.low, 0);
    const top = data.y.log ? fy(shown.high) : Math.max(up[up.length - 1], ys.high);
    const x = (v) => LEFT + ((fx(v) - low) / (high - low || 1)) * (width - LEFT - RIGHT);
    const y = (v) => {
      const share = (Math.max(fy(v), bottom) - bottom) / (top - bottom || 1);
      return height - BOTTOM - share * (height - TOP - BOTTOM);
    };
    state.scale = { low, high, width, height, x, y, along: fx, back: data.x.log ? (v) => 10 ** v : (v) => v };
    const svg = element("svg", { width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" });
    const inside = { y: TOP, height: height - TOP - BOTTOM };
    for (const band of data.bands || [])
      svg.append(element("rect", { class: `band ${band.kind}`, x: x(band.from), width: Math.max(1, x(band.to) - x(band.from)), ...inside }));
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
    for (const sign of data.marks || []) {
      svg.append(element("line", { class: "cursor", x1: x(sign.at), x2: x(sign.at), y1: TOP, y2: height - BOTTOM }));
      svg.append(text(sign.label, { x: 0, y: 0, "text-anchor": "end", transform: `translate(${x(sign.at) - 3} ${TOP + 2}) rotate(-90)` }));
    }
    data.lines.forEach((line, k) => {
      let pen = "M";
      const path = [];
      line.x.forEach((v, i) => {
        if (line.y[i] === null) pen = "M";
        else {
          path.push(`${pen}${x(v).toFixed(1)} ${y(line.y[i]).toFixed(1)}`);
          pen = "L";
        }
      });
      svg.append(element("path", { class: "line", d: path.join(""), style: `stroke:${colour(line, k)}`, "stroke-dasharray": dashes(line, k) }));
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
      group.append(element("circle", { cx: x(at), cy: y(value), r: 3.5, style: `fill:${colour(line, k)}` }));
      return `${line.label}: ${page.figure(value)}`;
    });
    const unit = (axis) => (axis.unit && axis.unit !== "-" ? ` ${axis.unit}` : "");
    label.textContent = `${data.x.label} ${page.figure(at)}${unit(data.x)} → ${read.filter(Boolean).join("; ")}${unit(data.y)}`;
  }

  // If a line passes a value more than once, the first passage is used.
  function valueAt(line, at) {
    for (let i = 0; i + 1 < line.x.length; i += 1) {
      const [a, b] = [line.x[i], line.x[i + 1]];
      if (((a <= at && at <= b) || (b <= at && at <= a)) && line.y[i] !== null && line.y[i + 1] !== null)
        return line.y[i] + (b === a ? 0 : ((at - a) / (b - a)) * (line.y[i + 1] - line.y[i]));
    }
    return null;
  }

  // Smallest and largest value of lists that may be too long to be spread into arguments.
  function range(lists) {
    let low = Infinity, high = -Infinity;
    for (const list of lists)
      for (const v of list) {
        if (v === null) continue;
        if (v < low) low = v;
        if (v > high) high = v;
      }
    return { low, high };
  }

  function decades({ low, high }) {
    const found = [];
    for (let k = Math.ceil(Math.log10(low) - 1e-9); k <= Math.log10(high) + 1e-9; k += 1) found.push(10 ** k);
    return found;
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
