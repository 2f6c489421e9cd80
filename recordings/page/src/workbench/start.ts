// Where one begins: scenes and recordings of the folder with their verdicts, and scenes to begin with.
import { api, type Recorded, type Scene, tried } from "./api";
import { ask, button, choice, element, labelled, option } from "./dom";
import { chip, type Runs } from "./runs";
import { words } from "./words";

export class Start {
  readonly host = element("section", { id: "start", "aria-label": words.welcomeTitle });
  private bundled: Record<string, string> = {};

  constructor(private readonly runs: Runs, private readonly saved: () => Promise<boolean>) {}

  async show(scene: Scene): Promise<void> {
    this.bundled = (await api.folder()).bundled;
    const told = (x: Recorded | undefined) => (x ? [x.older ? words.older : "", x.line].filter(Boolean).join(": ") : words.notRun);
    const verdict = (file: string) => this.runs.found.find((x) => x.name === file.replace(/\.ya?ml$/, ".mcap"));
    const open = (name: string, text: string, more?: HTMLElement) => element("li", {}, button(name, () => void this.open(name), { className: "open" }), more, element("small", { textContent: text }));
    this.host.replaceChildren(
      element("h2", { textContent: words.welcomeTitle }), element("p", { textContent: words.welcome }),
      element("div", { className: "buttons" }, button(words.fresh, () => this.begin(), { className: "primary" })),
      element("div", { className: "split" },
        element("div", {}, element("h3", { textContent: words.scenesHere }), element("ul", { className: "cards" }, ...(scene.scenes.length
          ? scene.scenes.map((name) => open(name, told(verdict(name)), verdict(name)?.older === false ? chip(verdict(name)!.state) : undefined)) : [element("li", { textContent: words.noScenes })]))),
        element("div", {}, element("h3", { textContent: words.bundled }), element("ul", { className: "cards" }, ...Object.entries(this.bundled).map(([name, about]) => open(name, about))))));
  }

  async open(name: string): Promise<void> {
    if (!(await this.saved())) return;
    await tried(api.open(name));
    document.documentElement.classList.remove("home");
  }

  // A new scene, as one of those that come with heavylift.
  begin(): void {
    const name = element("input", { value: "my-lift", spellcheck: false, required: true, autocomplete: "off" });
    const about = element("p", { className: "quiet" });
    let like = "lift";
    const tell = () => (about.textContent = like ? (this.bundled[like] ?? "") : words.nothingHelp);
    const picked = choice(words.like, [], (value) => {
      like = value;
      tell();
    });
    void api.folder().then((folder) => {
      this.bundled = folder.bundled;
      picked.replaceChildren(option("", words.nothing), ...Object.keys(this.bundled).map((x) => option(x, x, { selected: x === like })));
      tell();
    });
    ask(words.freshTitle, words.create, words.cancel, [labelled(words.name, name), labelled(words.like, picked), about], async () =>
      (await this.saved()) ? tried(api.begin(name.value.trim(), like)) : words.conflict);
    name.select();
  }

  copy(title: string, suggested: string): void {
    const name = element("input", { value: suggested, spellcheck: false, required: true, autocomplete: "off" });
    ask(title, words.create, words.cancel, [labelled(words.name, name)], async () => ((await this.saved()) ? tried(api.copy(name.value.trim())) : words.conflict));
    name.select();
  }
}
