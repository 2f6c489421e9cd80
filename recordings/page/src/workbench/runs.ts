// Runs of the scene: begin, pause, orders, stop; what they print; the recordings of the folder with their verdicts.
import { api, type Recorded, Refused, type RunMessage } from "./api";
import { button, element } from "./dom";
import { stateWords, words } from "./words";

export class Runs {
  readonly host = element("div", { id: "runs" });
  readonly begin = button(words.run, () => void this.start("run"), { id: "begin" });
  readonly others = [button(words.runLive, () => void this.start("live")), button(words.plan, () => void this.start("plan", words.budget), { title: words.planHelp })];
  private readonly told = element("span", { role: "status" });
  private readonly lines = element("pre", { id: "lines", tabIndex: 0 });
  private readonly list = element("ul", { id: "recordings" });
  private readonly live: HTMLElement;
  private readonly both = element("a", { target: "_blank", rel: "noopener", textContent: words.compare, hidden: true });
  private readonly watch = element("a", { target: "_blank", rel: "noopener", textContent: words.watch, hidden: true });
  private picked: string[] = [];

  constructor(private readonly saved: () => Promise<boolean>, private readonly shown: () => void) {
    const order = element("input", { "aria-label": words.command, placeholder: words.command, spellcheck: false });
    const give = () => void this.ask("command", order.value);
    order.onkeydown = (e) => e.key === "Enter" && give();
    this.live = element("span", { className: "live", hidden: true }, ...["pause", "continue", "stop"].map((x) => button(words[x as "pause"], () => void this.ask(x))), order, button(words.give, give));
    this.host.append(element("div", { className: "tools" }, this.live, this.watch, this.told), this.lines, element("h2", {}, words.recordings, " ", this.both), this.list);
  }

  private async ask(act: string, text = ""): Promise<void> {
    try {
      const answer = await api.run(act, text);
      if (answer) this.told.textContent = answer;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.told.textContent = error.message;
    }
  }

  private async start(act: string, text = ""): Promise<void> {
    if (!(await this.saved())) return;
    this.shown();
    this.told.textContent = words.starting;
    await this.ask(act, text);
  }

  take(message: RunMessage): void {
    this.live.hidden = !message.running;
    for (const x of [this.begin, ...this.others]) x.disabled = message.running;
    this.watch.hidden = !message.running || !message.live;
    if (message.live) this.watch.href = message.live;
    this.lines.textContent = message.lines.join("\n");
    this.lines.scrollTop = message.running ? this.lines.scrollHeight : 0;
    const stage = message.lines.at(-1)?.trim().replace(/\s+/g, " ") ?? words.starting;
    this.told.textContent = message.running ? words.running(stage) : words.ended(message.code ?? 0);
    document.documentElement.dataset.run = message.running ? "running" : `ended ${message.code}`;
    if (!message.running) void this.refresh();
  }

  private picker(name: string): HTMLElement {
    const box = element("input", { type: "checkbox" });
    box.onchange = () => {
      this.picked = box.checked ? [...this.picked, name] : this.picked.filter((x) => x !== name);
      this.compare();
    };
    return element("label", {}, box, words.beside);
  }

  private compare(): void {
    const [a, b] = this.picked.map(encodeURIComponent);
    this.both.hidden = this.picked.length !== 2;
    this.both.href = `compare/${a}/${b}`;
  }

  async refresh(): Promise<void> {
    const found = await api.recordings();
    const row = (x: Recorded) => element("li", {},
      element("span", { className: `state ${x.state}`, textContent: stateWords[x.state] ?? x.state }), ` ${x.name} `,
      this.picker(x.name),
      ...(["view", "report"] as const).map((kind) => element("a", { href: `result/${kind}/${encodeURIComponent(x.name)}`, target: "_blank", rel: "noopener", textContent: words[kind] })),
      element("small", { textContent: x.line }));
    this.picked = [];
    this.compare();
    this.list.replaceChildren(...(found.length ? found.map(row) : [element("li", { textContent: words.noRecordings })]));
  }
}
