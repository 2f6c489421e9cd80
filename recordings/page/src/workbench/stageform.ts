// The form of a stage: its name, and each order as target, verb, speed, ramp and end.
import type { Path } from "./api";
import { button, choice, element, labelled, option } from "./dom";
import { composed, GOALS, MOVES, type Order, OWN, parsed } from "./orders";
import type { Edit } from "./templates";
import type { Tree } from "./tree";
import { words } from "./words";

type Change = (edits: Edit[]) => void;
const BEGINNING: Record<string, string> = { hook: "hoist 1 m/min by 1 m", trolleys: "traverse 10 m/min by 1 m", cranes: "travel 10 m/min by 1 m", wait: "20 s" };

export class StageForm {
  // `hooks`: names of all hooks, as orders have them.
  constructor(private readonly hooks: () => string[], private readonly change: Change) {}

  made(tree: Tree, path: Path): HTMLElement[] {
    const written = tree.entries(tree.at(path)).map((x): [string, string] => [String(x.key), tree.plain(x.value)]);
    const at = Number(path.at(-1));
    const last = tree.entries(tree.at(path.slice(0, -1))).length - 1;
    const name = written.find(([key]) => key === "stage")?.[1] ?? "";
    const shift = (to: number, word: string) => button(word, () => this.change([{ path, value: to }]), { disabled: to < 0 || to > last });
    return [
      this.text(words.stageName, name, (value) => [{ path: [...path, "stage"], value }], "stage"),
      ...written.filter(([key]) => !OWN.includes(key)).map(([key, text]) => this.order(path, key, text)),
      this.adding(path, written.map(([key]) => key)),
      ...OWN.slice(1).filter((key) => written.some(([x]) => x === key)).map((key) =>
        this.text(key, written.find(([x]) => x === key)![1], (value) => [{ path: [...path, key], value: value || null }], key)),
      element("div", { className: "buttons" }, shift(at - 1, words.earlier), shift(at + 1, words.later),
        button(words.removeStage, () => this.change([{ path, value: null }]), { className: "quiet" })),
    ];
  }

  private text(label: string, value: string, edits: (value: string) => Edit[], key: string): HTMLElement {
    const input = element("input", { value, spellcheck: false, autocomplete: "off", "data-key": key });
    input.onchange = () => input.value.trim() !== value && this.change(edits(input.value.trim()));
    return labelled(label, input);
  }

  private order(path: Path, key: string, text: string): HTMLElement {
    const to = [...path, key];
    const order = key === "wait" ? null : parsed(text);
    const put = (value: string) => this.change([{ path: to, value }]);
    const head = element("div", { className: "head" }, element("b", { textContent: key === "wait" ? words.wait : key }),
      button("×", () => this.change([{ path: to, value: null }]), { className: "remove", title: words.remove, "aria-label": `${words.remove} ${key}` }));
    if (!order) return element("fieldset", { className: "order", "aria-label": key }, head, this.text(key === "wait" ? words.seconds : words.order, text, (value) => [{ path: to, value }], key));
    const part = (name: keyof Order, label: string, about = "") => {
      const input = element("input", { value: String(order[name]), spellcheck: false, autocomplete: "off", "data-key": name, title: about, placeholder: name === "ramp" ? words.noRamp : "" });
      input.onchange = () => put(composed({ ...order, [name]: input.value.trim() }));
      return labelled(label, input);
    };
    const picked = (name: "verb" | "goal", names: string[], label: string) => labelled(label, choice(label, (names.includes(order[name]) ? names : [order[name], ...names]).map((x) =>
      option(x, x, { selected: x === order[name] })), (value) => put(composed({ ...order, [name]: value })), { "data-key": name }));
    return element("fieldset", { className: "order", "aria-label": key }, head,
      element("div", { className: "pair" }, picked("verb", MOVES, words.verb), part("speed", words.speed)),
      element("div", { className: "pair" }, picked("goal", GOALS, words.goal), part("value", words.goalValue, words.goalHelp)),
      part("ramp", words.ramp, words.rampHelp));
  }

  private adding(path: Path, written: string[]): HTMLElement {
    const targets = ["all hooks", ...this.hooks(), "trolleys", "cranes", "wait"].filter((x) => !written.includes(x));
    return choice(words.addOrder, [option("", words.addOrder), ...targets.map((x) => option(x))], (target) => {
      const kind = target in BEGINNING ? target : "hook";
      if (target) this.change([{ path: [...path, target], value: BEGINNING[kind] }]);
    }, { className: "add-order" });
  }
}
