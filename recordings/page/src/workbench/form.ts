// A form of the mapping at the cursor: what is written there with its meaning, what could be added, what is assumed.
import type { Path } from "./api";
import { button, element, option } from "./dom";
import type { Key, Schema } from "./schema";
import { StageForm } from "./stageform";
import type { Entry, Tree } from "./tree";
import { type Edit, type Pasted, pasted, TABLES } from "./templates";
import { words } from "./words";

const MOST = 120; // fields
const HOOKS = ["on", "hook"]; // keys whose values are names of hooks

export class Form {
  readonly host = element("section", { id: "form", "aria-label": words.form });
  private shown = "";
  private readonly error = element("p", { className: "error", role: "alert" });
  private readonly stages: StageForm;

  constructor(
    private readonly edit: (edits: Edit[]) => Promise<string>,
    private readonly go: (path: Path) => void,
    private readonly hooks: () => string[],
  ) {
    this.stages = new StageForm(hooks, (edits) => void this.change(this.error, edits));
  }

  // Show the mapping that a path leads to, or the one around it; the field with the focus is left alone.
  show(tree: Tree, schema: Schema, at: Path): void {
    let path = [...at];
    const begun = path.length === 1 && !tree.at(path) && schema.keys(schema.at(path, () => "")).length > 0; // nothing is written there yet
    while (path.length && !begun && !tree.collection(tree.at(path))) path.pop();
    const ordered = path[0] === "actions" && path.length > 1 && tree.at(path.slice(0, 2))?.name.endsWith("Mapping");
    if (ordered) path = path.slice(0, 2);
    const node = tree.at(path);
    const entries = tree.entries(node);
    const known = schema.keys(schema.at(path, (p) => tree.type(p)));
    const now = JSON.stringify([path, tree.text(node)]);
    if (now === this.shown) return;
    const field = document.activeElement?.closest<HTMLElement>("#form [data-key]");
    if (field && JSON.parse(this.shown || "[[]]")[0].join() === path.join()) {
      const order = field.closest("fieldset")?.getAttribute("aria-label");
      const selector = `${order ? `fieldset[aria-label="${CSS.escape(order)}"] ` : ""}[data-key="${CSS.escape(field.dataset.key!)}"]`;
      queueMicrotask(() => this.host.querySelector<HTMLElement>(selector)?.focus());
    }
    this.shown = now;
    this.error.textContent = "";
    if (ordered) return this.host.replaceChildren(this.crumbs(path), this.error, ...this.stages.made(tree, path));
    const list = node?.name.endsWith("Sequence") ?? false;
    const fields = entries.slice(0, MOST).map((entry) => this.field(tree, schema, path, entry, known.find((x) => x.name === entry.key)));
    const table = TABLES[String(path.at(-1))];
    const spare = known.filter((x) => !entries.some((e) => e.key === x.name));
    this.host.replaceChildren(this.crumbs(path), this.error, ...fields, ...(list ? [] : this.assumed(path, spare, schema)),
      ...(table ? [this.pasting(path, table, entries)] : []), ...(list ? [] : [this.adding(path, spare, schema)]));
  }

  private crumbs(path: Path): HTMLElement {
    const steps = [[], ...path.map((_, i) => path.slice(0, i + 1))];
    const name = (to: Path) => (!to.length ? words.top : typeof to.at(-1) === "number" ? String(Number(to.at(-1)) + 1) : (words.parts[String(to.at(-1))] ?? String(to.at(-1))));
    return element("nav", { className: "crumbs", "aria-label": words.crumbs }, ...steps.map((to) => button(name(to), () => this.go(to), { "data-step": String(to.at(-1) ?? "") })));
  }

  // Rows of a spreadsheet, their units asked once.
  private pasting(path: Path, table: Pasted, there: Entry[]): HTMLElement {
    const rows = element("textarea", { rows: 3, placeholder: words.paste(table.columns), "aria-label": words.paste(table.columns), spellcheck: false });
    const units = (label: string, ...names: string[]) => element("select", { "aria-label": label, title: label }, ...names.map((x) => option(x)));
    const length = units(words.lengths, "m", "mm", "ft"), mass = units(words.masses, "t", "kg", "lb");
    const replace = element("input", { type: "checkbox" });
    const error = element("span", { className: "error", role: "alert" });
    const add = button(words.addRows, () => {
      const edits = pasted(rows.value, path, table, length.value, mass.value);
      if (typeof edits === "string") return void (error.textContent = words.noRow(edits));
      const gone = replace.checked ? there.filter((x) => !edits.some((e) => e.path.at(-1) === x.key)) : [];
      if (edits.length) void this.change(error, [...edits, ...gone.map((x) => ({ path: [...path, x.key], value: null }))]);
    });
    return element("details", { className: "paste", open: !there.length }, element("summary", { textContent: words.spreadsheet }), rows, !table.named && element("small", { textContent: words.replaces(table.columns) }),
      element("div", { className: "tools" }, words.lengths, length, ...(table.columns.includes("mass") ? [words.masses, mass] : []), table.named && there.length > 0 && element("label", {}, replace, ` ${words.replaceRows}`), add), error);
  }

  private field(tree: Tree, schema: Schema, path: Path, entry: Entry, key: Key | undefined): HTMLElement {
    const to = [...path, entry.key];
    const text = tree.text(entry.value);
    const about = key ? schema.about(key.part) : "";
    const label = element("label", { textContent: typeof entry.key === "number" ? String(entry.key + 1) : entry.key, title: about });
    const error = element("span", { className: "error", role: "alert" });
    const remove = button("×", () => void this.change(error, [{ path: to, value: null }]), { title: words.remove, "aria-label": `${words.remove} ${entry.key}`, className: "remove" });
    const row = element("div", { className: "field" }, label);
    if (tree.collection(entry.value) && (text.includes("\n") || entry.value!.name === "FlowMapping")) {
      const name = typeof entry.key === "number" ? tree.plain(tree.at([...to, "stage"])) || text.split("\n")[0] : words.wide(tree.entries(entry.value).length);
      row.append(button(`${name} ›`, () => this.go(to), { "data-key": String(entry.key) }));
    } else row.append(this.input(schema, key, text, to, error, label));
    if (typeof entry.key === "number") {
      const at = entry.key;
      const shift = (by: number, sign: string, word: string) => button(sign, () => void this.change(error, [{ path: to, value: at + by }]), { title: word, "aria-label": `${word} ${at + 1}`, className: "remove" });
      label.append(shift(-1, "↑", words.earlier), shift(1, "↓", words.later));
    }
    row.append(remove, element("small", { textContent: about }), error);
    return row;
  }

  private input(schema: Schema, key: Key | undefined, text: string, to: Path, error: HTMLElement, label: HTMLLabelElement): HTMLElement {
    const values = HOOKS.includes(String(to.at(-1))) ? this.hooks() : key ? schema.values(key.part) : [];
    const id = `field-${to.join("-").replace(/\W+/g, "_")}`;
    label.htmlFor = id;
    const made = element("input", { id, value: text, spellcheck: false, autocomplete: "off", "data-key": String(to.at(-1)) });
    if (values.length) {
      const list = element("datalist", { id: `${id}-values` }, ...values.map((value) => option(value)));
      made.setAttribute("list", list.id);
      label.append(list);
    }
    made.onchange = () => {
      const unit = /^[-+\d.]+( [^\s[\]{},]+)$/.exec(text)?.[1]; // a bare number keeps the unit that was written
      if (unit && /^[-+]?\d*\.?\d+$/.test(made.value.trim())) made.value = made.value.trim() + unit;
      if (made.value.trim() !== text) void this.change(error, [{ path: to, value: made.value }]);
    };
    return made;
  }

  // What heavylift assumes here: amber until it is accepted, which writes it.
  private assumed(path: Path, keys: Key[], schema: Schema): HTMLElement[] {
    return keys.filter((x) => /\bassumed\b/.test(schema.about(x.part)) && schema.standard(x.part)).map((key) => {
      const value = schema.standard(key.part);
      const error = element("span", { className: "error", role: "alert" });
      return element("div", { className: "field assumed", "data-assumed": key.name }, element("span", { textContent: key.name }), element("span", {}, element("b", { textContent: value }), ` ${words.assumed}`),
        button(words.accept, () => void this.change(error, [{ path: [...path, key.name], value }]), { "aria-label": `${words.accept} ${key.name}` }), element("small", { textContent: schema.about(key.part).split(";")[0] }), error);
    });
  }

  private adding(path: Path, keys: Key[], schema: Schema): HTMLElement {
    const name = element("input", { placeholder: words.add, "aria-label": words.add, spellcheck: false, "data-key": "add" });
    const value = element("input", { "aria-label": words.addValue, placeholder: words.addValue, spellcheck: false, hidden: true, "data-key": "add value" });
    const about = element("small");
    const error = element("span", { className: "error", role: "alert" });
    const list = element("datalist", { id: "keys" }, ...keys.map((x) => option(x.name, schema.about(x.part).slice(0, 80))));
    name.setAttribute("list", list.id);
    name.onchange = () => {
      value.hidden = !name.value.trim();
      const key = keys.find((x) => x.name === name.value.trim());
      about.textContent = key ? schema.about(key.part) : "";
      value.focus();
    };
    value.onchange = () => void this.change(error, [{ path: [...path, name.value.trim()], value: value.value }]);
    return element("div", { className: "field add" }, name, value, list, about, error);
  }

  private async change(error: HTMLElement, edits: Edit[]): Promise<void> {
    const refused = await this.edit(edits);
    (error.isConnected ? error : this.error).textContent = refused; // the fields may have been drawn anew meanwhile
  }
}
