// The stages as a bar: how long each takes, at what speed; dragged to another place, or longer and shorter at its edge.
import { clock } from "../data.js";
import { button, element } from "./dom";
import { words } from "./words";

export interface Shown { name: string; pace: string; from: number; to: number; action: number } // action: 0 where it is none

const NARROW = 0.015; // least share of the bar

export class StageBar {
  readonly host = element("div", { id: "stages", role: "group", "aria-label": words.stages });
  private stages: Shown[] = [];
  private editable = true;

  constructor(private readonly go: (stage: Shown) => void, private readonly move: (action: number, to: number) => void,
    private readonly stretch: (action: number, factor: number) => void) {}

  show(stages: Shown[], editable: boolean): void {
    if (JSON.stringify([stages, editable]) === JSON.stringify([this.stages, this.editable])) return;
    Object.assign(this, { stages, editable });
    const whole = Math.max(...stages.map((x) => x.to), 1e-9);
    this.host.replaceChildren(...stages.map((x) => this.part(x, Math.max(NARROW, (x.to - x.from) / whole))));
  }

  on(time: number): void {
    const at = this.stages.findLastIndex((x) => x.from < time - 1e-9);
    [...this.host.children].forEach((x, i) => x.classList.toggle("on", i === Math.max(0, at)));
  }

  private part(x: Shown, share: number): HTMLElement {
    const lasts = x.to - x.from;
    const title = [x.name, clock(lasts, lasts < 60 ? 1 : 0), x.pace].filter(Boolean).join(", ");
    const made = button("", () => this.go(x), { title: this.editable && x.action ? words.reorder(title) : title });
    made.append(element("span", { textContent: x.name }), element("small", { textContent: [lasts ? clock(lasts) : "", x.pace].filter(Boolean).join(" · ") }));
    const host = element("div", { className: "stage" }, made);
    host.style.flexGrow = String(share);
    if (!this.editable || !x.action) return host;
    made.draggable = true;
    made.ondragstart = (e) => e.dataTransfer!.setData("text/plain", String(x.action - 1));
    host.ondragover = (e) => {
      e.preventDefault();
      host.classList.add("over");
    };
    host.ondragleave = () => host.classList.remove("over");
    host.ondrop = (e) => {
      e.preventDefault();
      host.classList.remove("over");
      this.move(Number(e.dataTransfer!.getData("text/plain")), x.action - 1);
    };
    if (lasts) host.append(this.edge(x, host));
    return host;
  }

  // The edge between two bars: dragged, it changes the wait or the speeds of the stage.
  private edge(x: Shown, host: HTMLElement): HTMLElement {
    const made = element("i", { className: "edge", title: words.stretch });
    made.onpointerdown = (e) => {
      e.preventDefault();
      made.setPointerCapture(e.pointerId);
      const [begun, width] = [e.clientX, host.clientWidth];
      const factor = (at: PointerEvent) => Math.max(0.05, (width + at.clientX - begun) / width);
      made.onpointermove = (at) => {
        host.style.flexBasis = `${width * factor(at)}px`;
        host.style.flexGrow = "0";
        host.querySelector("small")!.textContent = clock((x.to - x.from) * factor(at), 1);
      };
      made.onpointerup = (at) => {
        made.onpointermove = made.onpointerup = null;
        if (Math.abs(at.clientX - begun) > 2) this.stretch(x.action - 1, factor(at));
      };
    };
    return made;
  }
}
