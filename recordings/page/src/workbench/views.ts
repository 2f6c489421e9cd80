// The lift in four views: three dimensions, plan, two elevations along the path at rest; in motion 3D and curves.
import { clock, Run } from "../data.js";
import { Stage } from "../stage.js";
import { api, type Check, type Drawing, type Path, type Picture, type Played, type State } from "./api";
import { button, choice, element, option } from "./dom";
import { Drag } from "./drag";
import { Measure } from "./measure";
import { Motion } from "./motion";
import { Pin } from "./pin";
import { type Shown, StageBar } from "./stagebar";
import type { Edit } from "./templates";
import { words } from "./words";

const DRAWN_ms = 60; // without a move of the slider until its drawings are asked for
const SHOWS = ["names", "loads", "gravity", "lugs", "dimensions"] as const;
const AT_FIRST = ["names", "loads", "gravity"];
const SPEEDS = [1, 5, 10, 20, 60];

export interface Action { name: string; pace: string; wait: number } // as it is written; wait: [s], 0 if it does not only wait
export interface Hands { edit(edits: Edit[] | (() => Edit[])): Promise<string>; written(path: Path): string[]; picked(path: Path): void; stretch(action: number, factor: number): void; actions(): Action[]; reached(t: number): void; left(): void; play(): void }

export class Views {
  readonly host = element("section", { id: "views", "aria-label": words.views3 });
  readonly motion = new Motion({
    enter: (run) => this.enter(run),
    seek: (now, run) => this.seek(now, run),
    grown: (run) => this.grown(run),
    playing: (on) => this.playing(on),
  });
  private readonly solid = element("div", { className: "view solid", "aria-label": words.three, role: "group" });
  private readonly sheets = [0, 1, 2].map(() => element("figure", { className: "view sheet" }));
  private readonly grid = element("div", { id: "grid" }, this.solid, ...this.sheets, this.motion.host);
  private readonly bar: StageBar;
  private readonly slider = element("input", { type: "range", min: 0, step: 1, "aria-label": words.states });
  private readonly told = element("output", { id: "state" });
  private readonly play = button("▶", () => this.motion.player?.play(!this.motion.player.playing), { className: "play", title: words.play, "aria-label": words.play });
  private readonly speed = choice(words.playSpeed, SPEEDS.map((x) => option(String(x), `${x} ×`, { selected: x === 10 })), (x) => this.motion.player && (this.motion.player.speed = Number(x)));
  private readonly rest = button(words.rest, () => this.leave(), { "aria-pressed": "true" });
  private readonly moving = button(words.motion, () => this.hands.play(), { "aria-pressed": "false", disabled: true });
  private readonly marks: HTMLElement[] = [];
  private stage: Stage | null = null;
  private picture: Picture | null = null;
  private still: Run | null = null; // the path at rest as a run
  private held: Picture | null = null; // a start pose that waits: the slider stands elsewhere, and the path may come
  private theme = "light";
  private timer = 0;
  private kept = ""; // a recording of the scene
  k = 0;

  private readonly drag: Drag;
  private readonly measure: Measure;
  private readonly pin = new Pin(() => this.stage!);
  private readonly measured = element("output", { className: "moving", hidden: true });

  constructor(private readonly hands: Hands) {
    this.drag = new Drag(() => this.stage!, () => (this.motion.run ? null : this.picture), (edits) => hands.edit(edits), (path) => hands.picked(path), (path) => hands.written(path));
    this.bar = new StageBar((x) => (this.motion.run ? this.motion.player!.jump(x.from) : this.at(x.to, x.name)),
      (action, to) => void this.tried(hands.edit([{ path: ["actions", action], value: to }])), (action, factor) => hands.stretch(action, factor));
    const move = button(words.move, () => {
      this.drag.on = move.classList.toggle("on");
      move.setAttribute("aria-pressed", String(this.drag.on));
      if (this.drag.on) this.leave();
      if (this.drag.on) this.go(0);
    }, { title: words.moveHelp, "aria-pressed": "false" });
    this.measure = new Measure(() => this.stage!, (text) => {
      this.measured.hidden = !text;
      this.measured.textContent = text;
    });
    const measure = button(words.measure, () => {
      this.measure.toggle(measure.classList.toggle("on"));
      measure.setAttribute("aria-pressed", String(this.measure.on));
    }, { title: words.measureHelp, "aria-pressed": "false" });
    const looks = element("div", { className: "segments", role: "group", "aria-label": words.look }, ...Object.entries(words.views).map(([view, word]) => button(word, () => this.stage?.look(view), { "data-view": view })));
    const shows = element("div", { className: "shows", role: "group", "aria-label": words.shown }, ...SHOWS.map((name) => {
      const box = element("input", { type: "checkbox", checked: AT_FIRST.includes(name) });
      box.onchange = () => this.show(name, box.checked);
      return element("label", {}, box, words[name]);
    }));
    const tools = element("div", { className: "toolbar" }, looks, element("div", { className: "segments", role: "group", "aria-label": words.hands }, move, measure), shows);
    this.solid.append(this.drag.told, this.measured);
    for (const panel of [this.solid, ...this.sheets]) {
      const mark = element("span", { className: "mark" });
      this.marks.push(mark);
      panel.append(mark, button("⤢", () => this.enlarge(panel), { className: "enlarge", title: words.larger, "aria-label": words.larger }));
    }
    this.slider.oninput = () => (this.motion.run ? this.motion.player!.jump(Number(this.slider.value)) : this.go(Number(this.slider.value)));
    const path = element("div", { id: "path" }, element("div", { className: "segments", role: "group", "aria-label": words.whatIsShown }, this.rest, this.moving),
      button("|◀", () => this.step(-1), { title: words.before, "aria-label": words.before }), this.play,
      button("▶|", () => this.step(1), { title: words.next, "aria-label": words.next }), this.slider, this.speed, this.told);
    this.host.append(tools, this.grid, this.bar.host, path);
    this.playable(false);
    new ResizeObserver(() => this.stage?.resize()).observe(this.solid);
  }

  private async tried(asked: Promise<string>): Promise<void> {
    const refused = await asked;
    if (refused) this.told.textContent = refused;
  }

  private show(name: string, on: boolean): void {
    if (on) this.stage?.labels.on.add(name);
    else this.stage?.labels.on.delete(name);
    this.stage?.ask();
  }

  private enlarge(panel: HTMLElement): void {
    const large = panel.classList.toggle("large");
    this.host.classList.toggle("one", large);
  }

  // ---- the path at rest ---------------------------------------------------------------------------------------

  // A new picture: a start pose at once where the slider is at the start, else when no path follows.
  take(picture: Picture): void {
    const before = this.picture?.version ?? this.version;
    if (this.motion.run && picture.version !== before) this.leave();
    if (picture.what === "start" && this.k > 0 && this.picture) {
      this.held = picture;
      return;
    }
    this.held = null;
    this.put(picture);
  }

  // Nothing more comes of this text.
  settle(): void {
    if (this.held) this.put(this.held);
    this.held = null;
  }

  clear(): void {
    this.leave();
    Object.assign(this, { picture: null, held: null, still: null, k: 0 });
    for (const sheet of this.sheets) sheet.querySelector("svg")?.remove();
    this.bar.show([], false);
  }

  private load(run: Run): void {
    this.pin.clear();
    if (this.stage) this.stage.load(run);
    else {
      this.stage = new Stage(this.solid, run);
      this.stage.resize();
      this.stage.controls.zoomToCursor = true;
      this.drag.attach(this.stage.gl.domElement);
      this.measure.attach(this.stage.gl.domElement);
    }
    this.stage.paint(this.theme);
  }

  private put(picture: Picture): void {
    const before = this.picture?.states[this.k];
    const same = before && this.k > 0 ? picture.states.findLastIndex((x) => x.action === before.action && (before.last || x.t <= before.t)) : 0;
    this.picture = picture;
    this.still = new Run({ status: "", facts: [], stages: [], events: [], peaks: [], ...picture });
    document.documentElement.dataset.picture = `${picture.what} ${picture.version}`;
    this.k = Math.max(0, Math.min(same, picture.states.length - 1));
    if (!this.motion.run) this.shown();
  }

  private shown(): void {
    if (!this.still || !this.picture) return;
    this.load(this.still);
    Object.assign(this.slider, { min: "0", step: "1", max: String(this.picture.states.length - 1), disabled: this.picture.states.length < 2 });
    this.stages();
    this.go(this.k);
  }

  // The bar anew: its words may have changed with the text.
  stages(): void {
    if (this.motion.run || !this.picture) return;
    const { states } = this.picture;
    const shown: Shown[] = [{ name: states[0].stage, pace: "", from: 0, to: 0, action: 0 }];
    const actions = this.hands.actions();
    for (let action = 1; action <= Math.max(actions.length, states.at(-1)!.action); action++) {
      const own = states.filter((x) => x.action === action);
      const { name = own[0]?.stage ?? "", pace = "", wait = 0 } = actions[action - 1] ?? {};
      const from = own[0]?.t ?? shown.at(-1)!.to;
      shown.push({ name, pace, from, to: own.at(-1)?.t ?? from + wait, action });
    }
    this.bar.show(shown, true);
  }

  go(k: number): void {
    const state = this.picture?.states[k];
    if (!state || this.motion.run) return;
    this.k = k;
    this.pin.clear();
    this.slider.value = String(k);
    this.tell([clock(state.t, 1), state.stage, state.event]);
    this.stage!.show(k);
    this.bar.on(state.t);
    clearTimeout(this.timer);
    if (k === 0) this.draw(this.picture!.drawings);
    else this.timer = window.setTimeout(() => void this.fetch(k), DRAWN_ms);
  }

  private tell(parts: string[]): void {
    const text = parts.filter(Boolean).join(" · ");
    this.told.textContent = this.told.title = text;
    this.slider.setAttribute("aria-valuetext", text);
  }

  private async fetch(k: number): Promise<void> {
    const { number } = this.picture!;
    const found = await api.drawings(number, k);
    if (found && this.picture?.number === number && this.k === k) this.draw(found);
  }

  private draw(drawings: Drawing[]): void {
    this.sheets.forEach((sheet, i) => {
      sheet.querySelector("svg, .empty")?.remove();
      sheet.querySelector("figcaption")?.remove();
      const drawing = drawings[i];
      if (!drawing) return void sheet.append(element("p", { className: "empty", textContent: words.noDrawing }));
      const parsed = new DOMParser().parseFromString(drawing.svg, "image/svg+xml").documentElement;
      sheet.append(element("figcaption", { textContent: words.drawing(drawing.title) }), document.importNode(parsed, true));
    });
  }

  // ---- in motion ----------------------------------------------------------------------------------------------

  open(name: string, played: Played): void {
    this.motion.open(name, played);
    document.documentElement.dataset.motion = name;
  }

  private enter(run: Run): void {
    this.load(run);
    this.grid.classList.add("motion");
    for (const large of this.grid.querySelectorAll(".large")) large.classList.remove("large");
    this.host.classList.remove("one");
    this.playable(true);
    this.grown(run);
  }

  private grown(run: Run): void {
    Object.assign(this.slider, { min: String(run.first), step: "any", max: String(run.last), disabled: false });
    this.bar.show(run.stages.map((x, i) => ({ name: x.name, pace: "", from: x.t, to: Math.max(x.t, run.stages[i + 1]?.t ?? run.last), action: 0 })), false);
    this.stage!.frame();
    this.hands.reached(run.last);
  }

  private seek(now: number, run: Run): void {
    Object.assign(this.slider, { max: String(run.last), value: String(now) });
    this.tell([`${run.clock(now)} / ${run.clock(run.last)}`, run.stages.findLast((x) => x.t <= now + 1e-9)?.name ?? "", run.events.findLast((x) => !x.inner && x.t <= now + 1e-9)?.text ?? ""]);
    this.pin.clear();
    this.stage!.show(now);
    this.bar.on(now + 1e-6);
  }

  private playing(on: boolean): void {
    this.play.textContent = on ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", on ? words.pause : words.play);
  }

  private playable(on: boolean): void {
    this.play.hidden = this.speed.hidden = !on;
    this.rest.setAttribute("aria-pressed", String(!on));
    this.moving.setAttribute("aria-pressed", String(on));
    this.recorded(this.kept);
  }

  // Which recording "in motion" would show, when nothing is played.
  recorded(name: string): void {
    this.kept = name;
    this.moving.disabled = !this.motion.run && !name;
    this.moving.title = this.motion.run ? this.motion.name : name;
  }

  // Back to the path at rest.
  leave(): void {
    if (!this.motion.run) return;
    this.motion.close();
    delete document.documentElement.dataset.motion;
    this.grid.classList.remove("motion");
    this.playable(false);
    this.shown();
    this.hands.left();
  }

  // ---- both ---------------------------------------------------------------------------------------------------

  // The end of the stage before, or of the next one.
  step(way: number): void {
    const { run, player } = this.motion;
    if (run) {
      const starts = [...run.stages.map((x) => x.t), run.last];
      return player!.jump((way > 0 ? starts.find((t) => t > player!.now + 1e-6) : starts.findLast((t) => t < player!.now - 1e-6)) ?? player!.now);
    }
    const { states } = this.picture ?? { states: [] };
    const found = way > 0 ? states.findIndex((x, k) => k > this.k && x.last) : states.findLastIndex((x, k) => k < this.k && x.last);
    this.go(found < 0 ? (way > 0 ? states.length - 1 : 0) : found);
  }

  // The state at a time, of a stage if there are several.
  at(t: number, stage: string): void {
    if (this.motion.run) return this.motion.player!.jump(t);
    const states = this.picture?.states ?? [];
    const near = (x: State) => Math.abs(x.t - t) + (stage && x.stage !== stage ? 1e6 : 0);
    const best = states.reduce((a, x, k) => (near(x) < near(states[a]) ? k : a), 0);
    if (states.length) this.go(best);
  }

  // The time and place of a check; `ends` of a clearance.
  point(check: Check, ends?: number[][]): void {
    const run = this.motion.run ?? this.still;
    if (!run || !this.stage) return;
    if (check.t !== undefined && check.t !== null) this.at(check.t, check.stage);
    const found = this.pin.show(run, check.subject, ends);
    document.documentElement.dataset.pinned = found ? check.subject : "";
  }

  // The end of an action, as its stage is chosen in outline or text.
  action(number: number): void {
    const k = this.picture?.states.findLastIndex((x) => x.action === number + 1) ?? -1;
    if (k >= 0 && !this.motion.run && this.picture!.states[this.k].action !== number + 1) this.go(k);
  }

  get hooks(): string[] {
    return this.picture?.hooks.map((x) => x.name.replace(".", " ")) ?? [];
  }

  get end(): number {
    return this.picture?.states.at(-1)?.t ?? 0;
  }

  get version(): string {
    return this.picture?.version ?? "";
  }

  mark(text: string): void {
    for (const mark of this.marks) {
      mark.textContent = this.motion.run ? "" : text;
      mark.parentElement!.classList.toggle("stale", !!text && !this.motion.run);
    }
  }

  paint(theme: string): void {
    this.theme = theme;
    this.stage?.paint(theme);
    this.motion.paint(theme);
  }
}
