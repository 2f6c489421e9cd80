// The lift in four views: three dimensions, plan, two elevations; a slider leads along the path at rest.
import { clock, Run } from "../data.js";
import { Stage } from "../stage.js";
import { api, type Drawing, type Picture, type State } from "./api";
import { button, element } from "./dom";
import { Drag } from "./drag";
import { Measure } from "./measure";
import type { Edit } from "./templates";
import { words } from "./words";

const DRAWN_ms = 60; // without a move of the slider until its drawings are asked for
const SHOWS = ["names", "loads", "gravity", "lugs", "dimensions"] as const;

export class Views {
  readonly host = element("section", { id: "views", "aria-label": words.states });
  private readonly solid = element("div", { className: "view solid", "aria-label": words.three, role: "group" });
  private readonly sheets = [0, 1, 2].map(() => element("figure", { className: "view sheet" }));
  private readonly bar = element("div", { id: "stages" });
  private readonly slider = element("input", { type: "range", min: 0, step: 1, "aria-label": words.states });
  private readonly told = element("output", { id: "state" });
  private readonly marks: HTMLElement[] = [];
  private stage: Stage | null = null;
  private picture: Picture | null = null;
  private held: Picture | null = null; // a start pose that waits: the slider stands elsewhere, and the path may come
  private theme = "light";
  private timer = 0;
  k = 0;

  private readonly drag: Drag;
  private readonly measure: Measure;
  private readonly measured = element("output", { className: "moving", hidden: true });

  constructor(private readonly moved: (state: State) => void, private readonly edit: (edits: Edit[]) => Promise<string>) {
    this.drag = new Drag(() => this.stage!, () => this.picture, edit);
    const grid = element("div", { id: "grid" }, this.solid, ...this.sheets);
    const tools = element("div", { className: "tools" });
    for (const [view, word] of Object.entries(words.views)) tools.append(button(word, () => this.stage?.look(view), { "data-view": view }));
    for (const name of SHOWS) {
      const box = element("input", { type: "checkbox", checked: ["names", "loads", "gravity"].includes(name) });
      box.onchange = () => this.show(name, box.checked);
      tools.append(element("label", {}, box, words[name]));
    }
    const move = button(words.move, () => {
      this.drag.on = move.classList.toggle("on");
      move.setAttribute("aria-pressed", String(this.drag.on));
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
    tools.append(move, measure);
    this.solid.append(tools, this.drag.told, this.measured);
    for (const panel of [this.solid, ...this.sheets]) {
      const mark = element("span", { className: "mark" });
      this.marks.push(mark);
      panel.append(mark, button("⤢", () => this.enlarge(panel), { className: "enlarge", title: words.larger, "aria-label": words.larger }));
    }
    this.slider.oninput = () => this.go(Number(this.slider.value));
    const path = element("div", { id: "path" }, button("◀", () => this.step(-1), { title: words.before, "aria-label": words.before }),
      this.slider, button("▶", () => this.step(1), { title: words.next, "aria-label": words.next }), this.told);
    this.host.append(grid, this.bar, path);
    new ResizeObserver(() => this.stage?.resize()).observe(this.solid);
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

  // A new picture: a start pose at once where the slider is at the start, else when no path follows.
  take(picture: Picture): void {
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
    Object.assign(this, { picture: null, held: null, k: 0 });
    for (const sheet of this.sheets) sheet.querySelector("svg")?.remove();
    this.bar.replaceChildren();
  }

  private put(picture: Picture): void {
    const before = this.picture?.states[this.k];
    const same = before && this.k > 0 ? picture.states.findLastIndex((x) => x.stage === before.stage && x.t <= before.t) : 0;
    this.picture = picture;
    const run = new Run({ status: "", facts: [], stages: [], events: [], peaks: [], ...picture });
    if (this.stage) this.stage.load(run);
    else {
      this.stage = new Stage(this.solid, run);
      this.stage.resize();
      this.drag.attach(this.stage.gl.domElement);
      this.measure.attach(this.stage.gl.domElement);
    }
    this.stage.paint(this.theme);
    this.slider.max = String(picture.states.length - 1);
    this.slider.disabled = picture.states.length < 2;
    this.stages();
    this.go(Math.max(0, Math.min(same, picture.states.length - 1)));
    document.documentElement.dataset.picture = `${picture.what} ${picture.version}`;
  }

  private stages(): void {
    const { states } = this.picture!;
    const ends = states.map((x, k) => ({ ...x, k })).filter((x) => x.last);
    this.bar.replaceChildren(...ends.map((x, i) => {
      const made = button("", () => this.go(x.k), { title: `${x.stage}, ${clock(x.t)}`, "data-k": x.k });
      made.append(element("span", { textContent: x.stage }));
      if (x.action) {
        made.title = words.reorder(made.title);
        made.draggable = true;
        made.ondragstart = (e) => e.dataTransfer!.setData("text/plain", String(x.action - 1));
        made.ondragover = (e) => e.preventDefault();
        made.ondrop = async (e) => {
          e.preventDefault();
          const refused = await this.edit([{ path: ["actions", Number(e.dataTransfer!.getData("text/plain"))], value: x.action - 1 }]);
          if (refused) this.told.textContent = refused;
        };
      }
      made.style.flexGrow = String(Math.max(0.02, (x.t - (ends[i - 1]?.t ?? 0)) / (states[states.length - 1].t || 1)));
      return made;
    }));
  }

  go(k: number): void {
    const state = this.picture?.states[k];
    if (!state) return;
    this.k = k;
    this.slider.value = String(k);
    const text = [clock(state.t, 1), state.stage, state.event].filter(Boolean).join(" · ");
    this.told.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.stage!.show(k);
    const ends = [...this.bar.children] as HTMLElement[];
    const on = ends.find((x) => Number(x.dataset.k) >= k);
    for (const x of ends) x.classList.toggle("on", x === on);
    clearTimeout(this.timer);
    if (k === 0) this.draw(this.picture!.drawings);
    else this.timer = window.setTimeout(() => void this.fetch(k), DRAWN_ms);
    this.moved(state);
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
      sheet.append(element("figcaption", { textContent: drawing.title }), document.importNode(parsed, true));
    });
  }

  // The end of the stage before, or of the next one.
  step(way: number): void {
    const { states } = this.picture ?? { states: [] };
    const found = way > 0 ? states.findIndex((x, k) => k > this.k && x.last) : states.findLastIndex((x, k) => k < this.k && x.last);
    this.go(found < 0 ? (way > 0 ? states.length - 1 : 0) : found);
  }

  // The state at a time of the path, of a stage if there are several.
  at(t: number, stage: string): void {
    const states = this.picture?.states ?? [];
    const near = (x: State) => Math.abs(x.t - t) + (stage && x.stage !== stage ? 1e6 : 0);
    const best = states.reduce((a, x, k) => (near(x) < near(states[a]) ? k : a), 0);
    if (states.length) this.go(best);
  }

  get version(): string {
    return this.picture?.version ?? "";
  }

  mark(text: string): void {
    for (const mark of this.marks) {
      mark.textContent = text;
      mark.parentElement!.classList.toggle("stale", !!text);
    }
  }

  paint(theme: string): void {
    this.theme = theme;
    this.stage?.paint(theme);
  }
}
