// Sweeps and limits as a form: what is varied, between which values; their pages.
import { button, choice, element, labelled, option } from "./dom";
import type { Runs } from "./runs";
import type { Tree } from "./tree";
import { words } from "./words";

const QUANTITY = /^[-+]?[\d.]+(e[-+]?\d+)?\s*[a-zA-Z%][\w/%*]*$/;
const USUAL = ["hoist speed", "hoist accel", "trolley speed", "trolley accel"];

interface Axis { path: string; from: string; to: string; by: string }

export class Studies {
  readonly host = element("div", { id: "studies" });
  private kind: "sweep" | "limits" = "sweep";
  private axes: Axis[] = [{ path: "", from: "", to: "", by: "" }];
  private readonly form = element("form", { "aria-label": words.studies });
  private readonly pages = element("ul", { className: "links" });
  private readonly known = element("datalist", { id: "quantities" });
  private values = new Map<string, string>();

  constructor(private readonly runs: Runs) {
    this.form.onsubmit = (e) => {
      e.preventDefault();
      void runs.start(this.kind, this.asked());
    };
    this.host.append(element("div", { className: "split" }, this.form, element("section", { "aria-label": words.studyPages }, element("h2", { textContent: words.studyPages }), this.pages)), this.known);
    runs.onlisted.push(() => this.list());
    this.draw();
  }

  // Numbers of the scene that can be varied, by path.
  take(tree: Tree): void {
    const found = new Map<string, string>();
    const walk = (path: (string | number)[]) => {
      for (const entry of tree.entries(tree.at(path))) {
        const to = [...path, entry.key];
        if (tree.collection(entry.value) && typeof entry.key === "string") walk(to);
        else if (QUANTITY.test(tree.plain(entry.value)) && path[0] !== "actions") found.set(to.join("."), tree.plain(entry.value));
      }
    };
    walk([]);
    this.values = found;
    this.known.replaceChildren(...[...found].map(([path, value]) => option(path, value)), ...USUAL.map((x) => option(x)));
  }

  private asked(): string {
    return this.axes.filter((x) => x.path).map((x) => {
      const range = x.from && x.to ? `=${x.from}..${x.to}` : "";
      return `${x.path}${range}${range && this.kind === "sweep" && x.by ? ` by ${x.by}` : ""}`;
    }).join("\n");
  }

  private draw(): void {
    const kinds = choice(words.studyKind, [option("sweep", words.sweep), option("limits", words.limits)].map((x) => Object.assign(x, { selected: x.value === this.kind })), (value) => {
      this.kind = value as "sweep";
      this.draw();
    });
    const field = (axis: Axis, name: keyof Axis, label: string, more = {}) => {
      const input = element("input", { value: axis[name], "aria-label": label, placeholder: label, spellcheck: false, autocomplete: "off", ...more });
      input.onchange = () => {
        axis[name] = input.value.trim();
        const now = this.values.get(axis.path);
        if (name === "path") (input.nextElementSibling as HTMLInputElement).placeholder = now ? words.now(now) : words.from;
      };
      return input;
    };
    this.form.replaceChildren(
      element("h2", { textContent: words.studies }),
      labelled(words.studyKind, kinds), element("p", { className: "quiet", textContent: this.kind === "sweep" ? words.sweepHelp : words.limitsHelp }),
      ...this.axes.map((axis) => element("div", { className: "axis" }, field(axis, "path", words.quantity, { list: "quantities" }), field(axis, "from", words.from), field(axis, "to", words.to), this.kind === "sweep" && field(axis, "by", words.by))),
      element("div", { className: "buttons" }, button(words.addAxis, () => {
        this.axes.push({ path: "", from: "", to: "", by: "" });
        this.draw();
      }), element("button", { className: "primary", textContent: words.startStudy })), this.runs.toldOfStudies);
  }

  private list(): void {
    this.pages.replaceChildren(...(this.runs.studies.length ? this.runs.studies.map((name) => element("li", {},
      element("a", { href: `kept/${name.split("/").map(encodeURIComponent).join("/")}`, target: "_blank", rel: "noopener", textContent: name.replace("/summary.html", "") })))
      : [element("li", { textContent: words.noStudies })]));
  }
}
