// The lift in three dimensions: boxes on their bodies, ropes coloured by use, ground; z is up, lengths are metres.
import {
  AmbientLight, BoxGeometry, BufferAttribute, BufferGeometry, Color, DirectionalLight, EdgesGeometry, GridHelper, Group,
  LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, PlaneGeometry, Quaternion, Scene,
  Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { locate, mix } from "./data.js";

const SKIES = { light: { sky: 0xe8edf2, ground: 0xc9d0d6, grid: 0xb3bcc4 }, dark: { sky: 0x12181f, ground: 0x1d252d, grid: 0x2d3842 } };
const SLACK = new Color(0x8a949e);

// Green at rest, yellow at half, red at the rated tension.
export function useColour(use, colour = new Color()) {
  return colour.setHSL(0.33 * (1 - Math.min(1, Math.max(0, use))), 0.85, 0.42);
}

export class Stage {
  constructor(host, run) {
    this.run = run;
    this.scene = new Scene();
    this.gl = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.gl.setPixelRatio(Math.min(2, window.devicePixelRatio));
    host.append(this.gl.domElement);
    this.host = host;
    this.camera = new PerspectiveCamera(36, 1, 1, 5000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.gl.domElement);
    this.controls.addEventListener("change", () => this.render());
    this.scene.add(new AmbientLight(0xffffff, 1.3));
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-120, -200, 300);
    this.scene.add(sun);
    this.frames = new Map([["world", this.scene]]);
    for (const body of run.bodies) {
      const group = new Group();
      this.frames.set(body.name, group);
      this.scene.add(group);
    }
    for (const box of run.boxes) this.addBox(box);
    this.measure();
    this.addGround();
    this.addRopes();
  }

  addBox({ body, centre, size, colour }) {
    const shape = new BoxGeometry(...size);
    const tint = new Color().setRGB(colour[0], colour[1], colour[2], "srgb");
    const mesh = new Mesh(shape, new MeshLambertMaterial({ color: tint, transparent: colour[3] < 1, opacity: colour[3] }));
    const edges = new LineSegments(new EdgesGeometry(shape), new LineBasicMaterial({ color: tint.clone().multiplyScalar(0.45) }));
    mesh.position.set(...centre);
    mesh.add(edges);
    this.frames.get(body)?.add(mesh);
  }

  // The middle and extent of all that is ever drawn.
  measure() {
    const low = new Vector3(Infinity, Infinity, 0);
    const high = new Vector3(-Infinity, -Infinity, 1);
    const p = new Vector3();
    const q = new Quaternion();
    const n = this.run.t.length;
    for (const box of this.run.boxes) {
      const body = this.run.bodies.find((b) => b.name === box.body);
      const reach = Math.hypot(...box.size) / 2;
      for (let i = 0; i < n; i += Math.max(1, n >> 5)) {
        p.set(...box.centre);
        if (body) {
          const x = body.x.subarray(7 * i);
          p.applyQuaternion(q.set(x[3], x[4], x[5], x[6])).add(new Vector3(x[0], x[1], x[2]));
        }
        const r = box.body === "world" ? 0 : Math.min(reach, 20);
        low.min(new Vector3(p.x - r, p.y - r, p.z - r));
        high.max(new Vector3(p.x + r, p.y + r, p.z + r));
      }
    }
    if (!isFinite(low.x)) {
      low.set(-5, -5, 0);
      high.set(5, 5, 5);
    }
    this.floor = Math.min(0, low.z);
    this.middle = low.clone().add(high).multiplyScalar(0.5);
    this.extent = Math.max(high.x - low.x, high.y - low.y, high.z - low.z, 1);
  }

  addGround() {
    const side = Math.max(2, 10 ** Math.floor(Math.log10(this.extent)));
    const cells = 2 * Math.ceil((1.6 * this.extent) / side);
    this.ground = new Mesh(new PlaneGeometry(cells * side, cells * side), new MeshLambertMaterial());
    this.ground.position.set(this.middle.x, this.middle.y, this.floor - 0.02);
    this.grid = new GridHelper(cells * side, cells, 0xffffff, 0xffffff);
    this.grid.material.vertexColors = false;
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(this.middle.x, this.middle.y, this.floor);
    this.scene.add(this.ground, this.grid);
  }

  addRopes() {
    const most = Math.max(0, ...this.run.rig.map((r) => r.lines.length));
    this.lines = new BufferGeometry();
    this.lines.setAttribute("position", new BufferAttribute(new Float32Array(6 * most), 3));
    this.lines.setAttribute("color", new BufferAttribute(new Float32Array(6 * most), 3));
    const ropes = new LineSegments(this.lines, new LineBasicMaterial({ vertexColors: true }));
    ropes.frustumCulled = false;
    this.scene.add(ropes);
  }

  paint(theme) {
    const { sky, ground, grid } = SKIES[theme];
    this.scene.background = new Color(sky);
    this.ground.material.color.set(ground);
    this.grid.material.color.set(grid);
    this.render();
  }

  look(view) {
    const m = this.middle;
    const r = this.extent * Math.max(1.6, 1.9 / this.camera.aspect);
    const from = {
      corner: [-0.62, -0.72, 0.32], along: [-1, 0, 0.06], across: [0, -1, 0.06], top: [0, -0.001, 1],
    }[view];
    this.camera.position.set(m.x + r * from[0], m.y + r * from[1], m.z + r * from[2]);
    this.controls.target.copy(m);
    this.controls.update();
    this.render();
  }

  show(now) {
    const { run, frames } = this;
    const at = locate(run.t, now);
    const q = new Quaternion();
    for (const body of run.bodies) {
      const { x } = body;
      const group = frames.get(body.name);
      group.position.set(mix(x, 7, at, 0), mix(x, 7, at, 1), mix(x, 7, at, 2));
      const [a, b] = [7 * at.i, 7 * at.j];
      group.quaternion.set(x[a + 3], x[a + 4], x[a + 5], x[a + 6]);
      group.quaternion.slerp(q.set(x[b + 3], x[b + 4], x[b + 5], x[b + 6]), at.w);
    }
    this.scene.updateMatrixWorld();
    this.hang(now, at);
    this.render();
  }

  hang(now, at) {
    const rig = this.run.rig.findLast((r) => r.t <= now) ?? { lines: [] };
    const place = this.lines.attributes.position;
    const colour = this.lines.attributes.color;
    const p = new Vector3();
    const c = new Color();
    rig.lines.forEach((line, k) => {
      const signal = this.run.signal.get("rope/tension/" + line.rope);
      const tension = signal ? mix(signal.y, 1, at, 0) : 0;
      const rated = this.run.rated[line.rope];
      if (tension > 0) useColour(rated ? tension / rated : 0, c);
      else c.copy(SLACK);
      [[line.a_body, line.a], [line.b_body, line.b]].forEach(([body, point], end) => {
        p.set(...point).applyMatrix4(frames(this, body));
        place.setXYZ(2 * k + end, p.x, p.y, p.z);
        colour.setXYZ(2 * k + end, c.r, c.g, c.b);
      });
    });
    this.lines.setDrawRange(0, 2 * rig.lines.length);
    place.needsUpdate = colour.needsUpdate = true;
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.host;
    if (!w || !h) return;
    this.gl.setSize(w, h);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  render() {
    if (this.scene.background) this.gl.render(this.scene, this.camera);
  }
}

const frames = (stage, body) => (stage.frames.get(body) ?? stage.scene).matrixWorld;
