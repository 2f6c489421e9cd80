// Runs of the scene: begin, progress, pause, orders, stop; what they print; the recordings of the folder with their verdicts.
import { api, type Kept, type Played, type Recorded, Refused, type RunMessage, tried } from "./api";
import { button, element, markup } from "./dom";
import { stateWords, words } from "./words";

export interface Acts {
  saved(): Promise<boolean>; // whether the file has what was typed
  shown(tab: "runs" | "studies"): void;
  play(name: string, played: Played): void;
  live(file: string): void;
  end(): number; // of the path at rest [s]
}

export const chip = (state: string) => element("span", { className: `state ${state}`, textContent: stateWords[state] ?? state });

export class Runs {
  readonly host = element("div", { id: "runs" });
  readonly begin = button(words.run, () => void this.start("run"), { id: "begin", title: words.runHelp });
  readonly plan = button(words.plan, () => void this.start("plan", words.budget), { title: words.planHelp });
  readonly control = element("div", { id: "control", role: "group", "aria-label": words.control, hidden: true });
  found: Recorded[] = [];
  onlisted: (() => void)[] = [];
  studies: string[] = [];
  private readonly told = element("span", { role: "status", className: "grow" });
  private readonly answer = element("span", { role: "status", className: "quiet" }); // to the last order
  readonly toldOfStudies = element("p", { role: "status" }); // the same, beside the form of studies
  private readonly progress = element("progress", { max: 1, "aria-label": words.progress });
  private readonly lines = element("pre", { id: "lines", tabIndex: 0, "aria-label": words.printed });
  private readonly list = element("table", { id: "recordings" });
  private readonly printed = element("h2", { textContent: words.printed });
  private running = false;
  private faulty = false;
  private readonly orders: HTMLElement;
  private readonly differences = element("div", { id: "differences" });
  private message: RunMessage | null = null;
  private followed = "";
  private readonly keeping = new Map<string, Kept>();
  private playing = "";

  constructor(private readonly acts: Acts) {
    const order = element("input", { "aria-label": words.command, placeholder: words.commandExample, spellcheck: false });
    const give = () => void this.ask("command", order.value);
    order.onkeydown = (e) => e.key === "Enter" && give();
    const act = (name: "pause" | "continue" | "stop") => button(words[name], () => void this.ask(name));
    this.control.append(this.progress, act("pause"), act("continue"), act("stop"));
    this.orders = element("div", { className: "tools orders", hidden: true }, ...Object.entries(words.halts).map(([text, order]) => button(text, () => void this.ask("command", order), { title: order })), order, button(words.give, give));
    this.host.append(
      element("div", { className: "split" },
        element("section", { "aria-label": words.recordings }, element("h2", { textContent: words.recordings }), this.list),
        element("section", { "aria-label": words.printed }, this.printed, element("div", { className: "tools" }, this.told, this.answer), this.orders, this.lines)), this.differences);
  }

  private tell(text: string): void {
    this.told.textContent = this.toldOfStudies.textContent = text;
  }

  async ask(act: string, text = ""): Promise<boolean> {
    try {
      const answer = await api.run(act, text);
      if (answer) this.answer.textContent = answer;
      return true;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      if (this.running) this.answer.textContent = error.message;
      else this.tell(error.message);
      return false;
    }
  }

  async start(act: string, text = ""): Promise<void> {
    if (!(await this.acts.saved())) return;
    this.acts.shown(act === "run" || act === "plan" ? "runs" : "studies");
    this.tell(words.starting);
    await this.ask(act, text);
  }

  take(message: RunMessage): void {
    const was = this.message?.running;
    this.message = message;
    const { running } = message;
    const single = running && message.do === "run";
    this.control.hidden = !running;
    this.orders.hidden = !single;
    for (const x of this.control.querySelectorAll("button")) x.hidden = !single && x.textContent !== words.stop;
    this.running = running;
    this.block(this.faulty);
    this.printed.textContent = words.printedOf(message.file);
    if (message.live && this.followed !== message.file) {
      this.followed = message.file;
      this.acts.live(message.file);
    }
    this.lines.textContent = message.lines.join("\n");
    this.lines.scrollTop = running ? this.lines.scrollHeight : 0;
    const last = message.lines.at(-1)?.trim().replace(/\s+/g, " ") ?? words.starting;
    const wrong = message.lines.find((x) => x.includes("error: "))?.replace(/^.*?error: /, "");
    this.tell(running ? words.running(last) : message.code && wrong ? wrong : words.ended(message.code ?? 0));
    const counted = /^(\d+) of (\d+) runs/.exec(last);
    if (counted) this.progress.value = Number(counted[1]) / Number(counted[2]);
    else if (!single || !message.live) this.progress.removeAttribute("value");
    if (running !== was) this.answer.textContent = "";
    document.documentElement.dataset.run = running ? "running" : `ended ${message.code}`;
    if (running) return;
    this.followed = "";
    void this.refresh().then(async () => {
      if (was && message.do === "run" && this.found.some((x) => x.name === message.file)) await this.play(message.file);
    });
  }

  // A scene with faults cannot be run.
  block(faulty: boolean): void {
    this.faulty = faulty;
    for (const x of [this.begin, this.plan]) x.disabled = this.running || faulty;
  }

  // How far the run is that is seen live.
  reached(t: number): void {
    const end = this.acts.end();
    if (this.message?.running && end) this.progress.value = Math.min(1, t / end);
  }

  async play(name: string, beside = ""): Promise<void> {
    try {
      const played = await api.played(name, beside);
      this.playing = name;
      this.acts.play(beside ? `${name} · ${beside}` : name, played);
      this.differences.replaceChildren(...(beside ? [element("h2", {}, words.differences(name, beside), " ", this.link(`compare/${encodeURIComponent(name)}/${encodeURIComponent(beside)}`, words.oneReport))] : []),
        ...played.differences.map((html) => element("div", { className: "table" }, markup(html))));
      this.draw();
      if (beside) this.differences.scrollIntoView({ block: "nearest" });
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.tell(error.message);
    }
  }

  // Nothing is played any more.
  left(): void {
    this.playing = "";
    this.differences.replaceChildren();
    this.draw();
  }

  // Report and drawings of what is played, else of the newest recording of the scene, unless that has changed since.
  async report(stem: string): Promise<void> {
    const found = this.found.find((x) => x.name === (this.playing || `${stem}.mcap`));
    if (found && !found.older) return this.keep(found.name);
    this.acts.shown("runs");
    this.tell(found ? words.runAgain(found.name) : words.runFirst);
  }

  private async keep(name: string): Promise<void> {
    this.acts.shown("runs");
    this.tell(words.keeping(name));
    const refused = await tried(api.keep(name).then((kept) => this.keeping.set(name, kept)));
    this.tell(refused || this.keeping.get(name)?.refused.join(" ") || words.kept);
    this.draw();
    document.documentElement.dataset.kept = name;
  }

  private link(href: string, text: string): HTMLElement {
    return element("a", { href, target: "_blank", rel: "noopener", textContent: text });
  }

  private row(x: Recorded): HTMLElement {
    const kept = this.keeping.get(x.name);
    const at = encodeURIComponent(x.name);
    const on = x.name === this.playing;
    const cells = [element("span", {}, chip(x.state), x.older && element("small", { className: "older", textContent: words.older })), element("b", { textContent: x.name, title: x.line }),
      element("span", { className: "buttons" }, button(on ? words.played : words.watch, () => void this.play(x.name), { disabled: on, "aria-label": `${words.watch} ${x.name}` }),
        this.playing && !on && button(words.beside, () => void this.play(this.playing, x.name), { title: words.besideHelp(this.playing), "aria-label": `${words.beside} ${x.name}` }),
        button(words.documents, () => void this.keep(x.name), { "aria-label": `${words.documents} ${x.name}` })),
      element("span", { className: "links" }, this.link(`result/view/${at}`, words.view), this.link(`result/report/${at}`, words.report),
        ...(kept?.made ?? []).map((name) => element("a", { href: `kept/${encodeURIComponent(name)}`, download: name, textContent: name.replace(x.name.replace(".mcap", "-"), "") })))];
    return element("tr", { className: on ? "on" : "" }, ...cells.map((cell) => element("td", {}, cell)));
  }

  private draw(): void {
    this.list.replaceChildren(element("tbody", {}, ...(this.found.length ? this.found.map((x) => this.row(x)) : [element("tr", {}, element("td", { textContent: words.noRecordings }))])));
  }

  async refresh(): Promise<void> {
    const folder = await api.folder();
    this.found = folder.recordings;
    this.studies = folder.studies;
    this.draw();
    for (const listed of this.onlisted) listed();
  }
}
