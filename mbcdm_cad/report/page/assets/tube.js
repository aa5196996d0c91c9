// A cable: a round tube along a centre line that changes with the drum's angle. Its triangles never change, only the
// positions of their corners, so that a new pose takes a few milliseconds.
(function (page) {
  "use strict";
  const SIDES = 8;

  class Tube {
    constructor(cable, lines) {
      this.cable = cable;
      this.lines = lines; // angles x points x 3, mm
      const rings = cable.points;
      this.centre = new Float32Array(rings * 3);
      this.geometry = new THREE.BufferGeometry();
      const corners = rings * SIDES + 2; // and one in the middle of each end
      this.position = new THREE.BufferAttribute(new Float32Array(corners * 3), 3).setUsage(THREE.DynamicDrawUsage);
      this.normal = new THREE.BufferAttribute(new Float32Array(corners * 3), 3).setUsage(THREE.DynamicDrawUsage);
      this.geometry.setAttribute("position", this.position);
      this.geometry.setAttribute("normal", this.normal);
      this.geometry.setIndex(new THREE.BufferAttribute(triangles(rings), 1));
    }

    // `share`: 0 at one end of the travel, 1 at the other.
    pose(share) {
      const { lines, centre, cable } = this;
      const count = cable.points * 3;
      const at = Math.min(Math.max(share, 0), 1) * (cable.angles - 1);
      const first = Math.min(Math.floor(at), cable.angles - 2);
      const rest = at - first;
      for (let k = 0; k < count; k += 1) {
        const from = lines[first * count + k];
        centre[k] = from + rest * (lines[(first + 1) * count + k] - from);
      }
      this.sweep();
    }

    sweep() {
      const { centre, cable } = this;
      const position = this.position.array;
      const normal = this.normal.array;
      const last = cable.points - 1;
      let ux = 0, uy = 0, uz = 0; // across the cable, carried along without twist
      for (let i = 0; i <= last; i += 1) {
        const a = 3 * Math.max(i - 1, 0);
        const b = 3 * Math.min(i + 1, last);
        let tx = centre[b] - centre[a], ty = centre[b + 1] - centre[a + 1], tz = centre[b + 2] - centre[a + 2];
        const length = Math.hypot(tx, ty, tz) || 1;
        tx /= length; ty /= length; tz /= length;
        if (i === 0) {
          if (Math.abs(tx) < 0.7) [ux, uy, uz] = [1, 0, 0];
          else [ux, uy, uz] = [0, 1, 0];
        }
        const along = ux * tx + uy * ty + uz * tz;
        ux -= along * tx; uy -= along * ty; uz -= along * tz;
        const size = Math.hypot(ux, uy, uz) || 1;
        ux /= size; uy /= size; uz /= size;
        const vx = ty * uz - tz * uy, vy = tz * ux - tx * uz, vz = tx * uy - ty * ux;
        for (let s = 0; s < SIDES; s += 1) {
          const c = COSINES[s], n = SINES[s], k = 3 * (i * SIDES + s);
          normal[k] = c * ux + n * vx;
          normal[k + 1] = c * uy + n * vy;
          normal[k + 2] = c * uz + n * vz;
          for (let axis = 0; axis < 3; axis += 1)
            position[k + axis] = centre[3 * i + axis] + cable.radius_mm * normal[k + axis];
        }
        if (i === 0 || i === last) {
          const k = 3 * ((last + 1) * SIDES + (i === 0 ? 0 : 1)), sign = i === 0 ? -1 : 1;
          position.set(centre.subarray(3 * i, 3 * i + 3), k);
          normal.set([sign * tx, sign * ty, sign * tz], k);
        }
      }
      this.position.needsUpdate = true;
      this.normal.needsUpdate = true;
      this.geometry.computeBoundingSphere();
      this.geometry.boundingBox = null;
    }
  }

  const COSINES = [], SINES = [];
  for (let s = 0; s < SIDES; s += 1) {
    COSINES.push(Math.cos((2 * Math.PI * s) / SIDES));
    SINES.push(Math.sin((2 * Math.PI * s) / SIDES));
  }

  function triangles(rings) {
    const found = [];
    for (let i = 0; i + 1 < rings; i += 1)
      for (let s = 0; s < SIDES; s += 1) {
        const a = i * SIDES + s, b = i * SIDES + ((s + 1) % SIDES);
        found.push(a, b, b + SIDES, a, b + SIDES, a + SIDES);
      }
    const start = rings * SIDES, end = start + 1, last = (rings - 1) * SIDES;
    for (let s = 0; s < SIDES; s += 1) {
      const next = (s + 1) % SIDES;
      found.push(start, next, s, end, last + s, last + next);
    }
    return new Uint16Array(found);
  }

  page.Tube = Tube;
})(window.drivePage);
