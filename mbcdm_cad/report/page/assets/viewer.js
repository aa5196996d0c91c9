// The drive in 3D. Frame of the mechanism, mm, Z up; drawn only when something has changed.
(function (page) {
  "use strict";
  const VIEWS = {
    output: [0.6, 1.2, 0.65], rear: [-0.7, -1.2, 0.6], front: [0, 1, 0], back: [0, -1, 0],
    left: [-1, 0, 0], right: [1, 0, 0], top: [0, 0.0001, 1], bottom: [0, 0.0001, -1],
  };
  const SELECTED = new THREE.Color(0x2f86ff);

  class Viewer {
    constructor(canvas, data, buffer) {
      this.canvas = canvas;
      this.data = data;
      this.angle = 0;
      this.explosion = 0;
      this.selected = null;
      this.listeners = { picked: [], posed: [] };
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, stencil: true, alpha: true });
      this.renderer.localClippingEnabled = true;
      this.scene = new THREE.Scene();
      this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 4000);
      this.camera.up.set(0, 0, 1);
      this.lights();
      this.build(buffer);
      this.section = new page.Section(this);
      this.scene.add(this.section.group);
      this.controls = new THREE.OrbitControls(this.camera, canvas);
      this.controls.rotateSpeed = 0.8;
      this.controls.addEventListener("change", () => this.draw());
      this.pose(0);
      this.look("output");
      this.watchPointer();
      new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
      this.resize();
    }

    on(event, listener) {
      this.listeners[event].push(listener);
    }

    tell(event, value) {
      for (const listener of this.listeners[event]) listener(value);
    }

    lights() {
      this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8d929c, 1.5));
      const lights = [[-0.6, 0.9, 1.0, 1.9], [1.0, -0.2, 0.6, 0.7], [0.1, -1.0, 0.4, 0.35]];
      for (const [x, y, z, strength] of lights) {
        const light = new THREE.DirectionalLight(0xffffff, strength);
        light.position.set(x, y, z);
        this.camera.add(light, light.target);
      }
      this.scene.add(this.camera);
    }

    build(buffer) {
      const { data } = this;
      this.bodies = new Map();
      this.entries = []; // everything that can be seen, picked and hidden: items and cables
      for (const body of data.bodies) {
        const node = new THREE.Group();
        node.name = body.name;
        node.matrixAutoUpdate = false;
        this.scene.add(node);
        this.bodies.set(body.name, {
          ...body, node, axis: new THREE.Vector3(...body.axis), point: new THREE.Vector3(...body.point),
        });
      }
      const shapes = new Map();
      for (const [name, part] of Object.entries(data.parts)) shapes.set(name, shapeOf(part, buffer));
      for (const item of data.items) this.addItem(item, shapes.get(item.part));
      this.tubes = data.cables.map((cable) => this.addCable(cable, page.pointsOf(buffer, cable.line)));
      const still = this.entries.filter((e) => e.body && this.bodies.get(e.body).ratio === 0);
      const base = still.reduce((a, b) => (b.mass_g > a.mass_g ? b : a), still[0] || this.entries[0]);
      const items = this.entries.filter((entry) => !entry.tube);
      this.offsets = page.explodedOffsets(items, this.bodies, base);
    }

    addItem(item, shape) {
      const surface = surfaceOf(item.colour);
      const line = new THREE.LineBasicMaterial({ color: 0x15181d });
      const mesh = new THREE.Mesh(shape.surface, surface);
      const edges = new THREE.LineSegments(shape.edges, line);
      const node = new THREE.Group();
      node.name = item.name;
      node.matrixAutoUpdate = false;
      node.add(mesh, edges);
      const place = placeOf(item.place);
      node.matrix.copy(place);
      this.bodies.get(item.body).node.add(node);
      const box = shape.surface.boundingBox.clone().applyMatrix4(place);
      const along = new THREE.Vector3().setFromMatrixColumn(place, 2);
      const entry = {
        ...item, node, mesh, edges, place, box, along, materials: [surface, line], colour: surface.color.clone(),
        shown: true, tube: null,
      };
      mesh.userData.entry = entry;
      this.entries.push(entry);
    }

    addCable(cable, lines) {
      const tube = new page.Tube(cable, lines);
      const surface = surfaceOf(cable.colour);
      const mesh = new THREE.Mesh(tube.geometry, surface);
      mesh.name = cable.name;
      this.scene.add(mesh);
      const entry = {
        ...cable, body: null, node: mesh, mesh, materials: [surface], colour: surface.color.clone(), shown: true, tube,
      };
      mesh.userData.entry = entry;
      this.entries.push(entry);
      return tube;
    }

    entry(name) {
      return this.entries.find((entry) => entry.name === name) || null;
    }

    // Drum angle in degrees, held within the travel; every body turns by its ratio, cables wind along their routes.
    pose(angle) {
      const half = this.data.half_travel_deg;
      this.angle = Math.min(Math.max(angle, -half), half);
      this.turnBodies(this.angle);
      for (const tube of this.tubes) tube.pose((this.angle + half) / (2 * half));
      this.section?.update();
      this.tell("posed", this.angle);
      this.draw();
    }

    turnBodies(angle) {
      const turn = new THREE.Matrix4(), back = new THREE.Matrix4();
      for (const body of this.bodies.values()) {
        turn.makeRotationAxis(body.axis, (body.ratio * angle * Math.PI) / 180);
        body.node.matrix.makeTranslation(body.point).multiply(turn);
        body.node.matrix.multiply(back.makeTranslation(-body.point.x, -body.point.y, -body.point.z));
        body.node.matrixWorldNeedsUpdate = true;
      }
    }

    explode(share) {
      this.explosion = Math.min(Math.max(share, 0), 1);
      const shift = new THREE.Matrix4();
      for (const entry of this.entries) {
        if (entry.tube) continue;
        const offset = this.offsets.get(entry.name);
        shift.makeTranslation(offset.x * this.explosion, offset.y * this.explosion, offset.z * this.explosion);
        entry.node.matrix.copy(shift).multiply(entry.place);
        entry.node.matrixWorldNeedsUpdate = true;
      }
      this.refresh();
      this.fit();
    }

    cut(axis, offset, flipped) {
      if (!axis) this.section.set(null, 0);
      else {
        const normal = new THREE.Vector3(axis === "x" ? 1 : 0, axis === "y" ? 1 : 0, axis === "z" ? 1 : 0);
        if (flipped) normal.negate();
        this.section.set(normal, flipped ? -offset : offset);
      }
      this.draw();
    }

    show(names, shown) {
      const wanted = new Set(names);
      for (const entry of this.entries) if (wanted.has(entry.name)) entry.shown = shown;
      this.refresh();
    }

    showOnly(names) {
      const wanted = new Set(names);
      for (const entry of this.entries) entry.shown = wanted.has(entry.name);
      this.refresh();
    }

    refresh() {
      for (const entry of this.entries) entry.node.visible = entry.shown && !(entry.tube && this.explosion > 0);
      this.section.update();
      this.draw();
    }

    select(names) {
      this.selected = new Set(names || []);
      this.mark(this.selected);
      this.draw();
    }

    mark(names) {
      for (const entry of this.entries) {
        entry.mesh.material.color.copy(entry.colour);
        if (names.has(entry.name)) entry.mesh.material.color.lerp(SELECTED, 0.8);
      }
    }

    // The entry visible at a position of the canvas (-1 to 1 in both directions), or null.
    at(x, y) {
      const ray = new THREE.Raycaster();
      ray.setFromCamera(new THREE.Vector2(x, y), this.camera);
      const meshes = this.entries.filter((entry) => entry.node.visible).map((entry) => entry.mesh);
      // Inner sides count: where one is visible, the cap of a section is shown.
      for (const mesh of meshes) mesh.material.side = THREE.DoubleSide;
      const hits = ray.intersectObjects(meshes, false);
      for (const mesh of meshes) mesh.material.side = THREE.FrontSide;
      const hit = hits.find((found) => !this.section.hides(found.point));
      return hit ? hit.object.userData.entry : null;
    }

    watchPointer() {
      let down = null;
      this.canvas.addEventListener("pointerdown", (event) => (down = [event.clientX, event.clientY]));
      this.canvas.addEventListener("pointerup", (event) => {
        if (!down || Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
        const frame = this.canvas.getBoundingClientRect();
        const x = ((event.clientX - frame.left) / frame.width) * 2 - 1;
        const y = 1 - ((event.clientY - frame.top) / frame.height) * 2;
        this.tell("picked", this.at(x, y));
      });
    }

    // The camera looks from a named direction; all visible parts fit into the picture.
    look(view) {
      const way = new THREE.Vector3(...VIEWS[view]).normalize();
      this.camera.position.copy(this.controls.target).addScaledVector(way, 1000);
      this.fit();
    }

    turn(azimuth, polar) {
      const offset = this.camera.position.clone().sub(this.controls.target);
      const ball = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
      ball.theta += azimuth;
      ball.phi = Math.min(Math.max(ball.phi + polar, 0.01), Math.PI - 0.01);
      const turned = new THREE.Vector3().setFromSpherical(ball);
      this.camera.position.copy(this.controls.target).add(new THREE.Vector3(turned.x, -turned.z, turned.y));
      this.controls.update();
      this.draw();
    }

    zoom(factor) {
      this.camera.zoom *= factor;
      this.camera.updateProjectionMatrix();
      this.draw();
    }

    // All visible parts, or the named ones, fit into the picture at every angle of the travel.
    fit(names) {
      const wanted = names ? new Set(names) : null;
      const seen = this.entries.filter((entry) => entry.node.visible && (!wanted || wanted.has(entry.name)));
      if (seen.length === 0) return;
      this.camera.lookAt(this.controls.target);
      this.camera.updateMatrixWorld();
      const half = this.data.half_travel_deg;
      const box = this.extent(seen, this.camera);
      const turning = wanted ? [] : seen.filter((entry) => entry.body && this.bodies.get(entry.body).ratio !== 0);
      for (const angle of turning.length ? [-half, 0, half] : []) {
        this.turnBodies(angle);
        this.extent(turning, this.camera, box);
      }
      this.turnBodies(this.angle);
      this.half = { across: (box.max.x - box.min.x) / 2, up: (box.max.y - box.min.y) / 2 };
      const centre = box.getCenter(new THREE.Vector3()).applyMatrix4(this.camera.matrixWorld);
      const way = this.camera.position.clone().sub(this.controls.target).normalize();
      this.controls.target.copy(centre);
      this.camera.position.copy(centre).addScaledVector(way, 1000);
      this.camera.zoom = 1;
      this.resize();
      this.controls.update();
    }

    resize() {
      const frame = this.canvas.parentElement.getBoundingClientRect();
      const width = Math.max(1, Math.round(frame.width)), height = Math.max(1, Math.round(frame.height));
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
      this.renderer.setSize(width, height, false);
      const { across, up } = this.half || { across: 100, up: 100 };
      // Buttons cover the top of the picture and a hint its bottom: the drive is shown between them.
      const above = this.covered(".corner", (box) => box.bottom - frame.top);
      const below = this.covered(".hint", (box) => frame.bottom - box.top);
      const free = Math.max(height - above - below, height / 3);
      const scale = 1.04 * Math.max((2 * up) / free, (2 * across) / width);
      Object.assign(this.camera, {
        top: scale * (above + free / 2), bottom: scale * (above + free / 2 - height),
        left: (-scale * width) / 2, right: (scale * width) / 2,
      });
      this.camera.updateProjectionMatrix();
      this.draw();
    }

    // Height in pixels of an element over the picture; 0 if it is not there.
    covered(selector, height) {
      const element = this.canvas.parentElement.querySelector(selector);
      const box = element && element.getBoundingClientRect();
      return box && box.height ? Math.max(0, height(box)) : 0;
    }

    // A picture of the items `present` in their positions, those of `joining` marked, as the address of a PNG. Another
    // renderer draws it, so that the view does not change; it has no sections.
    picture(present, joining, width, height) {
      if (!this.small) {
        this.small = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true });
        this.small.setSize(width, height, false);
      }
      const there = new Set(present);
      const visible = this.entries.map((entry) => entry.node.visible);
      for (const entry of this.entries) entry.node.visible = there.has(entry.name);
      this.section.group.visible = false;
      this.mark(new Set(joining));
      const camera = this.camera.clone();
      camera.position.set(...VIEWS.output).normalize().multiplyScalar(1000);
      camera.lookAt(0, 0, 0);
      camera.updateMatrixWorld();
      const box = this.extent(this.entries.filter((entry) => entry.node.visible), camera);
      const middle = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3());
      const half = 0.52 * Math.max(size.y, (size.x * height) / width), across = (half * width) / height;
      Object.assign(camera, { zoom: 1, near: -4000, far: 4000 });
      Object.assign(camera, { left: middle.x - across, right: middle.x + across, top: middle.y + half, bottom: middle.y - half });
      camera.updateProjectionMatrix();
      this.small.render(this.scene, camera);
      const address = this.small.domElement.toDataURL("image/png");
      this.entries.forEach((entry, k) => (entry.node.visible = visible[k]));
      this.section.group.visible = this.section.on;
      this.mark(this.selected || new Set());
      return address;
    }

    // Box of the entries in the frame of a camera, from all points, because the box about a sector's own box is much
    // wider.
    extent(entries, camera, box = new THREE.Box3()) {
      const toCamera = new THREE.Matrix4(), { min, max } = box;
      this.scene.updateMatrixWorld();
      for (const { mesh } of entries) {
        const m = toCamera.multiplyMatrices(camera.matrixWorldInverse, mesh.matrixWorld).elements;
        const points = mesh.geometry.attributes.position.array;
        for (let k = 0; k < points.length; k += 3) {
          const a = points[k], b = points[k + 1], c = points[k + 2];
          const x = m[0] * a + m[4] * b + m[8] * c + m[12];
          const y = m[1] * a + m[5] * b + m[9] * c + m[13];
          const z = m[2] * a + m[6] * b + m[10] * c + m[14];
          if (x < min.x) min.x = x;
          if (x > max.x) max.x = x;
          if (y < min.y) min.y = y;
          if (y > max.y) max.y = y;
          if (z < min.z) min.z = z;
          if (z > max.z) max.z = z;
        }
      }
      return box;
    }

    lineColour(css) {
      for (const entry of this.entries) if (entry.edges) entry.materials[1].color.set(css);
      this.draw();
    }

    draw() {
      if (this.waiting) return;
      this.waiting = true;
      requestAnimationFrame(() => {
        this.waiting = false;
        this.renderer.render(this.scene, this.camera);
        this.frames = (this.frames || 0) + 1;
        if (this.frames === 1) performance.mark("first-picture");
      });
    }
  }

  function shapeOf(part, buffer) {
    const position = new THREE.BufferAttribute(page.pointsOf(buffer, part.points), 3);
    const surface = new THREE.BufferGeometry();
    surface.setAttribute("position", position);
    surface.setAttribute("normal", new THREE.BufferAttribute(page.arrayOf(buffer, part.normals), 3, true));
    surface.setIndex(new THREE.BufferAttribute(page.arrayOf(buffer, part.triangles), 1));
    surface.computeBoundingBox();
    surface.computeBoundingSphere();
    const edges = new THREE.BufferGeometry();
    edges.setAttribute("position", position);
    edges.setIndex(new THREE.BufferAttribute(page.arrayOf(buffer, part.edges), 1));
    return { surface, edges };
  }

  function placeOf(rows) {
    return new THREE.Matrix4().set(...rows, 0, 0, 0, 1);
  }

  function surfaceOf(colour) {
    return new THREE.MeshStandardMaterial({
      color: new THREE.Color(...colour), metalness: 0.15, roughness: 0.55,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
  }

  page.Viewer = Viewer;
})(window.drivePage);
