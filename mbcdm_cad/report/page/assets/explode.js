// Displacement of each part in the exploded view: along its own axis (that of its body if it turns), in the direction
// that leaves the heaviest fixed part first, and far enough to clear the parts before it.
(function (page) {
  "use strict";
  const GAP = 0.035; // of the size of the whole

  // Offsets in mm by name of the entry, as Vector3. `entries`: {name, body, box (Box3 in the assembly), along (Vector3)}.
  page.explodedOffsets = function (entries, bodies, base) {
    const whole = new THREE.Box3();
    for (const entry of entries) whole.union(entry.box);
    const gap = GAP * whole.getSize(new THREE.Vector3()).length();
    const ways = new Map();
    const wayOf = (along, boxes) => {
      const [low, high] = span(boxes, along), [from, to] = span([base.box], along);
      return to - low <= high - from ? along.clone() : along.clone().negate();
    };
    for (const body of bodies.values()) {
      if (body.ratio === 0) continue;
      const own = entries.filter((entry) => entry.body === body.name);
      if (own.length === 0) continue;
      const way = wayOf(body.axis, own.map((entry) => entry.box));
      for (const entry of own) ways.set(entry, way);
    }
    for (const entry of entries) {
      if (entry !== base && !ways.has(entry)) ways.set(entry, wayOf(entry.along, [entry.box]));
    }
    const offsets = new Map([[base.name, new THREE.Vector3()]]);
    const rows = new Map();
    for (const [entry, way] of ways) {
      const key = way.toArray().map((v) => v.toFixed(2)).join();
      if (!rows.has(key)) rows.set(key, { way, row: [] });
      rows.get(key).row.push(entry);
    }
    for (const { way, row } of rows.values()) {
      const placed = [{ entry: base, end: span([base.box], way)[1] }];
      row.sort((a, b) => span([a.box], way)[0] - span([b.box], way)[0] || (a.name < b.name ? -1 : 1));
      for (const entry of row) {
        const [low, high] = span([entry.box], way);
        let shift = 0;
        for (const before of placed) {
          if (overlapAcross(entry.box, before.entry.box, way)) shift = Math.max(shift, before.end + gap - low);
        }
        placed.push({ entry, end: high + shift });
        offsets.set(entry.name, way.clone().multiplyScalar(shift));
      }
    }
    return offsets;
  };

  function span(boxes, along) {
    let low = Infinity, high = -Infinity;
    for (const box of boxes)
      for (const x of [box.min.x, box.max.x])
        for (const y of [box.min.y, box.max.y])
          for (const z of [box.min.z, box.max.z]) {
            const at = x * along.x + y * along.y + z * along.z;
            low = Math.min(low, at);
            high = Math.max(high, at);
          }
    return [low, high];
  }

  function overlapAcross(first, second, along) {
    return ["x", "y", "z"].every(
      (axis) =>
        Math.abs(along[axis]) > 0.7 ||
        (first.min[axis] < second.max[axis] - 0.05 && second.min[axis] < first.max[axis] - 0.05)
    );
  }
})(window.drivePage);
