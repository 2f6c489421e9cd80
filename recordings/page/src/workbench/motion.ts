// A run in place of the path at rest: recorded or as it goes on, played in time, with its loads as curves beside the lift.
import "uplot/dist/uPlot.min.css";
import { Charts } from "../charts.js";
import { Run } from "../data.js";
import { listen } from "../live.js";
import { Player } from "../player.js";
import type { Played } from "./api";
import { element } from "./dom";
import { words } from "./words";

const GROW_ms = 250; // how often charts of a run that goes on are drawn anew
const SPEED = 10;

export interface Shows { enter(run: Run): void; seek(now: number, run: Run): void; grown(run: Run): void; playing(on: boolean): void }

export class Motion {
  readonly host = element("section", { id: "signals", "aria-label": words.signals });
  run: Run | null = null;
  player: Player | null = null;
  name = "";
  private readonly picker = element("div", { className: "picker" });
  private readonly curves = element("div", { className: "curves", tabIndex: 0 });
  private charts: Charts | null = null;
  private source: EventSource | null = null;
  private theme = "light";
  private drawn = 0;

  constructor(private readonly shows: Shows) {
    this.host.append(element("details", {}, element("summary", { textContent: words.whichSignals }), this.picker), this.curves);
    new ResizeObserver(() => this.curves.clientWidth && this.charts?.resize()).observe(this.curves);
  }

  open(name: string, played: Played): void {
    this.close();
    this.begin(name, new Run(played.run));
    const { run } = this;
    void run!.refine().then((finer) => finer && this.run === run && this.charts?.grow());
    this.player!.jump(run!.first);
  }

  // The run that goes on, until it ends; its recording takes its place then.
  live(name: string): void {
    this.close();
    this.source = listen("live", {
      begun: (run) => {
        this.begin(name, run);
        this.player!.follow(true);
      },
      grown: (run) => {
        if (performance.now() - this.drawn > GROW_ms) {
          this.drawn = performance.now();
          this.charts?.grow();
          this.shows.grown(run);
        }
        if (this.player!.following) this.player!.follow(true);
        document.documentElement.dataset.samples = String(run.t.length);
      },
      ended: (run) => {
        this.charts?.grow();
        this.shows.grown(run);
      },
      lost: () => {},
    });
  }

  private begin(name: string, run: Run): void {
    Object.assign(this, { name, run });
    this.shows.enter(run);
    this.player = new Player(run, (now) => {
      this.shows.seek(now, run);
      this.charts?.cursor(now);
    });
    this.player.speed = SPEED;
    this.player.onchange = () => this.shows.playing(this.player!.playing);
    this.charts = new Charts(this.curves, this.picker, run, (t) => this.player!.jump(t));
    this.charts.paint(this.theme);
  }

  close(): void {
    this.source?.close();
    this.player?.play(false);
    this.charts?.on.clear();
    this.charts?.draw();
    this.picker.replaceChildren();
    Object.assign(this, { source: null, run: null, player: null, charts: null, name: "" });
  }

  paint(theme: string): void {
    this.theme = theme;
    this.charts?.paint(theme);
  }
}
