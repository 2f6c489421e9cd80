// The lift in three dimensions: shapes on their bodies, ropes coloured by use, pads, ground; z is up, lengths in metres.
import {
  AmbientLight, BoxGeometry, Color, CylinderGeometry, DirectionalLight, EdgesGeometry, GridHelper, Group,
  LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, OrthographicCamera, PerspectiveCamera, PlaneGeometry,
  Quaternion, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { lastBefore, locate, mix } from "./data.js";
import { Labels } from "./labels.js";
import { measure } from "./measure.js";
import { Pads } from "./pads.js";
import { Quality, software } from "./quality.js";
import { Ropes } from "./ropes.js";

const SKIES = { light: { sky: 0xe8edf2, ground: 0xc9d0d6, grid: 0xb3bcc4 }, dark: { sky: 0x12181f, ground: 0x1d252d, grid: 0x2d3842 } };
const FROM = { corner: [-0.62, -0.72, 0.32], along: [-1, 0, 0], across: [0, -1, 0], top: [0, -0.0001, 1] };
const MARGIN = 1.1; // room around what is shown
const AROUND = 0.9; // of its own length: room on each side of what is followed

export class Stage {
  constructor(host, run) {
    this.host = host;
    const soft = software();
    this.gl = new WebGLRenderer({ antialias: !soft });
    this.quality = new Quality(soft, () => this.ask());
    host.append(this.gl.domElement);
    this.cameras = { perspective: new PerspectiveCamera(36, 1, 1, 5000), parallel: new OrthographicCamera() };
    for (const camera of Object.values(this.cameras)) camera.up.set(0, 0, 1);
    this.camera = this.cameras.perspective;
    this.controls = new OrbitControls(this.camera, this.gl.domElement);
    this.controls.addEventListener("start", () => (this.view = null));
    this.controls.addEventListener("change", () => this.ask());
    this.view = "corner";
    this.aspect = 1;
    this.load(run);
  }

  // Show a run in place of the one before; who has turned the picture keeps his view.
  load(run) {
    this.scene?.traverse((x) => {
      x.geometry?.dispose();
      x.material?.dispose();
    });
    const on = this.labels?.on;
    this.labels?.canvas.remove();
    Object.assign(this, { run, pads: null, grid: null, scene: new Scene() });
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
    for (const box of run.boxes) this.addShape(box);
    this.ropes = new Ropes(this.scene, run);
    this.labels = new Labels(this.host, run, (body) => (this.frames.get(body) ?? this.scene).matrixWorld);
    if (on) this.labels.on = on;
    this.ground = new Mesh(new PlaneGeometry(1, 1), new MeshLambertMaterial());
    this.scene.add(this.ground);
    this.at = { i: 0, j: 0, w: 0 };
    this.rig = [];
    this.followed = null;
    this.frame();
    if (on) this.resize();
  }

  addShape({ body, centre, size, colour, turn, kind }) {
    const [x, y, z] = size;
    const shape = {
      box: () => new BoxGeometry(x, y, z),
      ball: () => new SphereGeometry(0.5, 24, 16).scale(x, y, z),
      cylinder: () => new CylinderGeometry(0.5, 0.5, 1, 16).rotateX(Math.PI / 2).scale(x, y, z),
    }[kind]();
    const tint = new Color().setRGB(colour[0], colour[1], colour[2], "srgb");
    const glass = colour[3] < 1;
    const mesh = new Mesh(shape, new MeshLambertMaterial({ color: tint, transparent: glass, opacity: colour[3], depthWrite: !glass }));
    if (kind === "box") {
      mesh.add(new LineSegments(new EdgesGeometry(shape), new LineBasicMaterial({ color: tint.clone().multiplyScalar(0.45) })));
    }
    mesh.position.set(...centre);
    mesh.quaternion.set(...turn);
    this.frames.get(body)?.add(mesh);
  }

  // Take the measure of all that is ever drawn; a growing run is measured again now and then.
  frame() {
    const { low, high, lowest, middle, radius } = measure(this.run);
    this.middle = middle;
    this.radius = radius;
    this.measured = this.run.t.length;
    this.box = { low, high };
    Object.assign(this.cameras.perspective, { near: radius / 200, far: radius * 60 });
    Object.assign(this.cameras.parallel, { near: 0, far: radius * 8 });
    const floor = Math.min(0, lowest);
    const extent = 2 * Math.max(high.x - low.x, high.y - low.y, 0.5 * radius);
    const side = 10 ** Math.floor(Math.log10(extent / 3));
    const cells = 2 * Math.ceil((1.3 * extent) / side / 2) + 2;
    const at = (x) => Math.round(x / side) * side;
    this.ground.scale.set(cells * side, cells * side, 1);
    this.ground.position.set(at(middle.x), at(middle.y), floor - radius * 2e-4);
    this.grid?.removeFromParent();
    this.grid = new GridHelper(cells * side, cells, 0xffffff, 0xffffff);
    this.grid.material.vertexColors = false;
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(at(middle.x), at(middle.y), floor - radius * 1e-4);
    this.scene.add(this.grid);
    this.pads ??= new Pads(this.scene, this.run);
    this.pads.stand(floor, radius);
    this.paint(this.theme ?? "light");
    if (this.view) this.look(this.view);
  }

  paint(theme) {
    this.theme = theme;
    const { sky, ground, grid } = SKIES[theme];
    this.scene.background = new Color(sky);
    this.ground.material.color.set(ground);
    this.grid.material.color.set(grid);
    this.labels.theme = theme;
    this.ask();
  }

  // What a view has to hold: all that is ever drawn, or what is followed.
  held() {
    const drawn = this.followed && this.run.boxes.filter((b) => b.body === this.followed);
    if (!drawn?.length) return this.box;
    const reach = AROUND * Math.max(...drawn.map((b) => Math.max(...b.size)));
    const centre = this.frames.get(this.followed).position;
    return { low: centre.clone().subScalar(reach), high: centre.clone().addScalar(reach) };
  }

  // A view from one side is drawn in parallels, as a drawing is; the one from a corner in perspective.
  look(view) {
    this.view = view;
    const { low, high } = this.held();
    const direction = new Vector3(...FROM[view]).normalize();
    const right = new Vector3(0, 0, 1).cross(direction).normalize();
    const up = direction.clone().cross(right);
    const middle = low.clone().add(high).multiplyScalar(0.5);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => new Vector3(...["x", "y", "z"].map((i, n) => ((k >> n) & 1 ? high : low)[i] - middle[i])));
    const most = (axis) => Math.max(1e-3, ...corners.map((p) => Math.abs(p.dot(axis))));
    const { aspect } = this;
    let distance = 4 * this.radius;
    if (view === "corner") {
      this.camera = this.cameras.perspective;
      const rise = Math.tan((this.camera.fov * Math.PI) / 360) / MARGIN;
      const needs = (p) => p.dot(direction) + Math.max(Math.abs(p.dot(up)) / rise, Math.abs(p.dot(right)) / (rise * aspect));
      distance = Math.max(1e-3, ...corners.map(needs));
    } else {
      this.camera = this.cameras.parallel;
      this.half = MARGIN * Math.max(most(up), most(right) / aspect);
      this.camera.zoom = 1;
      this.widen();
    }
    this.controls.object = this.camera;
    this.camera.position.copy(middle).addScaledVector(direction, distance);
    this.controls.target.copy(middle);
    this.controls.update();
    this.ask();
  }

  // The parallel camera's frame for the shape of the picture.
  widen() {
    const { parallel } = this.cameras;
    Object.assign(parallel, { left: -this.half * this.aspect, right: this.half * this.aspect, top: this.half, bottom: -this.half });
    parallel.updateProjectionMatrix();
  }

  // Keep a body where it is in the picture; null: let it go.
  follow(body) {
    this.followed = body;
    this.look(this.view ?? "corner");
  }

  show(now) {
    const { run, frames } = this;
    if (!run.t.length) return;
    if (run.t.length > 1.5 * this.measured + 20) this.frame();
    const at = locate(run.t, now);
    const q = new Quaternion();
    const before = frames.get(this.followed)?.position.clone();
    for (const body of run.bodies) {
      const { x } = body;
      const group = frames.get(body.name);
      group.position.set(mix(x, 7, at, 0), mix(x, 7, at, 1), mix(x, 7, at, 2));
      const [a, b] = [7 * at.i, 7 * at.j];
      group.quaternion.set(x[a + 3], x[a + 4], x[a + 5], x[a + 6]);
      group.quaternion.slerp(q.set(x[b + 3], x[b + 4], x[b + 5], x[b + 6]), at.w);
    }
    if (before) {
      const moved = frames.get(this.followed).position.clone().sub(before);
      this.controls.target.add(moved);
      this.camera.position.add(moved);
      this.controls.update();
    }
    this.at = at;
    this.rig = run.rig[lastBefore(run.rig, now)]?.lines ?? [];
    this.scene.updateMatrixWorld();
    this.ropes.hang(now, at, (body) => (frames.get(body) ?? this.scene).matrixWorld);
    this.pads.grow();
    this.ask();
  }

  // Bodies were put elsewhere by hand: ropes follow.
  moved() {
    this.scene.updateMatrixWorld();
    this.ropes.hang(0, this.at, (body) => (this.frames.get(body) ?? this.scene).matrixWorld);
    this.ask();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.host;
    if (!w || !h) return;
    this.gl.setSize(w, h);
    this.ropes.resize(w, h);
    this.labels.resize(w, h);
    this.aspect = this.cameras.perspective.aspect = w / h;
    this.cameras.perspective.updateProjectionMatrix();
    if (this.half) this.widen();
    if (this.view) this.look(this.view);
    this.ask();
  }

  // Draw once before the next picture, however many things have changed.
  ask() {
    this.asked ??= requestAnimationFrame((at) => this.draw(this.quality.ratio(at)));
  }

  draw(ratio) {
    cancelAnimationFrame(this.asked);
    this.asked = undefined;
    if (this.gl.getPixelRatio() !== ratio) this.gl.setPixelRatio(ratio);
    this.gl.render(this.scene, this.camera);
    this.labels.draw(this.camera, this.at, this.rig);
  }

  // The picture as it stands, at its best, with a line of text below, as the address of a PNG.
  picture(text = "") {
    this.draw(this.quality.best);
    const drawn = this.gl.domElement;
    const scale = drawn.width / this.host.clientWidth;
    const canvas = Object.assign(document.createElement("canvas"), { width: drawn.width, height: drawn.height + (text ? 26 * scale : 0) });
    const c = canvas.getContext("2d");
    c.fillStyle = this.theme === "dark" ? "#161c23" : "#fff";
    c.fillRect(0, 0, canvas.width, canvas.height);
    c.drawImage(drawn, 0, 0);
    c.drawImage(this.labels.canvas, 0, 0, drawn.width, drawn.height);
    c.scale(scale, scale);
    Object.assign(c, { font: "13px system-ui, sans-serif", textBaseline: "middle", fillStyle: this.theme === "dark" ? "#dbe3ea" : "#1d2733" });
    c.fillText(text, 10, this.host.clientHeight + 13);
    return canvas.toDataURL("image/png");
  }
}
