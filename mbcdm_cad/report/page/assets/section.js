// A section through all visible parts: one clipping plane, and a hatched cap where it cuts a part. The stencil finds the
// caps: where more back faces than front faces of a part are visible behind the plane, the view is into the part.
(function (page) {
  "use strict";
  const HATCH_MM = 2.2;

  class Section {
    constructor(viewer) {
      this.viewer = viewer;
      this.plane = new THREE.Plane(new THREE.Vector3(0, -1, 0), 0);
      this.on = false;
      this.group = new THREE.Group();
      this.hatches = [hatch(false), hatch(true)];
      this.caps = [];
    }

    // `normal` points to the removed side; `offset` in mm from the origin along it.
    set(normal, offset) {
      this.on = normal !== null;
      if (this.on) {
        this.plane.normal.set(-normal.x, -normal.y, -normal.z);
        this.plane.constant = offset;
      }
      const planes = this.on ? [this.plane] : null;
      for (const part of this.viewer.entries) for (const material of part.materials) material.clippingPlanes = planes;
      this.update();
    }

    hides(point) {
      return this.on && this.plane.distanceToPoint(point) < -1e-3;
    }

    update() {
      this.group.visible = this.on;
      if (!this.on) return;
      if (this.caps.length === 0) this.build();
      const along = this.plane.normal;
      const across = new THREE.Vector3(Math.abs(along.z) > 0.9 ? 1 : 0, 0, Math.abs(along.z) > 0.9 ? 0 : 1);
      const u = new THREE.Vector3().crossVectors(across, along).normalize();
      const v = new THREE.Vector3().crossVectors(along, u);
      for (const cap of this.caps) {
        const { mesh } = cap.entry;
        mesh.updateWorldMatrix(true, false);
        const ball = mesh.geometry.boundingSphere;
        const centre = ball.center.clone().applyMatrix4(mesh.matrixWorld);
        const far = this.plane.distanceToPoint(centre);
        const cut = cap.entry.shown && Math.abs(far) < ball.radius;
        for (const node of [cap.back, cap.front, cap.face]) node.visible = cut;
        if (!cut) continue;
        for (const node of [cap.back, cap.front]) node.matrix.copy(mesh.matrixWorld);
        centre.addScaledVector(along, -far);
        const reach = Math.sqrt(ball.radius ** 2 - far ** 2) * 1.02;
        const position = cap.face.geometry.getAttribute("position"), uv = cap.face.geometry.getAttribute("uv");
        [[-1, -1], [1, -1], [1, 1], [-1, 1]].forEach(([a, b], k) => {
          const corner = centre.clone().addScaledVector(u, a * reach).addScaledVector(v, b * reach);
          position.setXYZ(k, corner.x, corner.y, corner.z);
          uv.setXY(k, corner.dot(u) / HATCH_MM, corner.dot(v) / HATCH_MM);
        });
        position.needsUpdate = uv.needsUpdate = true;
      }
    }

    build() {
      this.viewer.entries.forEach((entry, k) => {
        const order = 10 + 2 * k;
        const counting = (side, operation) => {
          const material = new THREE.MeshBasicMaterial({
            side, clippingPlanes: [this.plane], colorWrite: false, depthWrite: false, depthTest: false,
            stencilWrite: true, stencilFunc: THREE.AlwaysStencilFunc,
            stencilFail: operation, stencilZFail: operation, stencilZPass: operation,
          });
          const node = new THREE.Mesh(entry.mesh.geometry, material);
          node.matrixAutoUpdate = false;
          node.frustumCulled = false;
          node.renderOrder = order;
          return node;
        };
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(12), 3));
        geometry.setAttribute("uv", new THREE.BufferAttribute(new Float32Array(8), 2));
        geometry.setIndex([0, 1, 2, 0, 2, 3]);
        const colour = entry.colour.clone().lerp(new THREE.Color(1, 1, 1), 0.12);
        const face = new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
          color: colour, map: this.hatches[k % 2], side: THREE.DoubleSide,
          stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc,
          stencilFail: THREE.KeepStencilOp, stencilZFail: THREE.ZeroStencilOp, stencilZPass: THREE.ZeroStencilOp,
        }));
        face.frustumCulled = false;
        face.renderOrder = order + 1;
        const cap = {
          entry, face,
          back: counting(THREE.BackSide, THREE.IncrementWrapStencilOp),
          front: counting(THREE.FrontSide, THREE.DecrementWrapStencilOp),
        };
        this.group.add(cap.back, cap.front, cap.face);
        this.caps.push(cap);
      });
    }
  }

  function hatch(mirrored) {
    const size = 64;
    const canvas = document.createElement("canvas");
    canvas.width = canvas.height = size;
    const pen = canvas.getContext("2d");
    pen.fillStyle = "#ffffff";
    pen.fillRect(0, 0, size, size);
    pen.strokeStyle = "#7a7f87";
    pen.lineWidth = 7;
    if (mirrored) {
      pen.translate(size, 0);
      pen.scale(-1, 1);
    }
    pen.beginPath();
    for (const shift of [-size, 0, size]) {
      pen.moveTo(shift - 8, size + 8);
      pen.lineTo(shift + size + 8, -8);
    }
    pen.stroke();
    const texture = new THREE.CanvasTexture(canvas);
    texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
    texture.colorSpace = THREE.SRGBColorSpace;
    texture.anisotropy = 4;
    return texture;
  }

  page.Section = Section;
})(window.drivePage);
