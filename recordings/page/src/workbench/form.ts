// A form of the mapping at the cursor: what is written there with its meaning, what could be added.
import type { Path } from "./api";
import { button, element } from "./dom";
import type { Key, Schema } from "./schema";
import type { Entry, Tree } from "./tree";
import { type Edit, type Pasted, pasted, TABLES, templates } from "./templates";
import { words } from "./words";

const MOST = 120; // fields

export class Form {
  readonly host = element("section", { id: "form", "aria-label": words.form });
  private shown = "";

  constructor(
    private readonly edit: (edits: Edit[]) => Promise<string>,
    private readonly go: (at: number) => void,
  ) {}

  // Show the mapping that a path leads to, or the one around it; the field with the focus is left alone.
  show(tree: Tree, schema: Schema, at: Path): void {
    const path = [...at];
    while (path.length && !tree.collection(tree.at(path))) path.pop();
    const node = tree.at(path);
    const entries = tree.entries(node);
    const known = schema.keys(schema.at(path, (p) => tree.type(p)));
    const now = JSON.stringify([path, tree.text(node)]);
    if (now === this.shown) return;
    if (this.host.contains(document.activeElement) && JSON.parse(this.shown || "[[]]")[0].join() === path.join()) {
      const name = (document.activeElement as HTMLElement).dataset.key;
      queueMicrotask(() => this.host.querySelector<HTMLElement>(`[data-key="${CSS.escape(name ?? "")}"]`)?.focus());
    }
    this.shown = now;
    const list = node?.name.endsWith("Sequence") ?? false;
    const fields = entries.slice(0, MOST).map((entry) => this.field(tree, schema, path, entry, known.find((x) => x.name === entry.key)));
    const table = TABLES[String(path.at(-1))];
    this.host.replaceChildren(this.crumbs(tree, path, schema), ...fields, ...(table ? [this.pasting(path, table)] : []), ...(list ? [] : [this.adding(path, known.filter((x) => !entries.some((e) => e.key === x.name)), schema)]));
  }

  private crumbs(tree: Tree, path: Path, schema: Schema): HTMLElement {
    const known = templates(schema);
    const groups = [...new Set(known.map((x) => x.group))];
    const insert = element("select", { "aria-label": words.insert, className: "insert" }, element("option", { textContent: words.insert, value: "" }),
      ...groups.map((group) => element("optgroup", { label: group }, ...known.flatMap((x, i) => (x.group === group ? [element("option", { value: String(i), textContent: x.label })] : [])))));
    const error = element("span", { className: "error", role: "alert" });
    insert.onchange = async () => {
      const template = known[Number(insert.value)];
      insert.value = "";
      error.textContent = await this.edit([template.edit(tree)]);
    };
    const steps = [[], ...path.map((_, i) => path.slice(0, i + 1))];
    return element("nav", { className: "crumbs" }, ...steps.map((to) => button(to.length ? String(to.at(-1)) : words.top, () => this.go(tree.at(to)?.from ?? 0))), insert, error);
  }

  // Rows of a spreadsheet, their units asked once.
  private pasting(path: Path, table: Pasted): HTMLElement {
    const rows = element("textarea", { rows: 3, placeholder: words.paste(table.columns), "aria-label": words.paste(table.columns), spellcheck: false });
    const units = (label: string, ...names: string[]) => element("select", { "aria-label": label, title: label }, ...names.map((x) => element("option", { value: x, textContent: x })));
    const length = units(words.lengths, "m", "mm"), mass = units(words.masses, "t", "kg");
    const error = element("span", { className: "error", role: "alert" });
    const add = button(words.addRows, async () => {
      const edits = pasted(rows.value, path, table, length.value, mass.value);
      error.textContent = typeof edits === "string" ? words.noRow(edits) : edits.length ? await this.edit(edits) : "";
    });
    return element("div", { className: "field paste" }, rows, element("div", { className: "tools" }, words.lengths, length, ...(table.columns.includes("mass") ? [words.masses, mass] : []), add), error);
  }

  private field(tree: Tree, schema: Schema, path: Path, entry: Entry, key: Key | undefined): HTMLElement {
    const to = [...path, entry.key];
    const text = tree.text(entry.value);
    const about = key ? schema.about(key.part) : "";
    const label = element("label", { textContent: typeof entry.key === "number" ? String(entry.key + 1) : entry.key, title: about });
    const error = element("span", { className: "error", role: "alert" });
    const remove = button("×", () => void this.change(error, to, null), { title: words.remove, "aria-label": `${words.remove} ${entry.key}`, className: "remove" });
    const row = element("div", { className: "field" }, label);
    if (tree.collection(entry.value) && (text.includes("\n") || (entry.value!.name === "FlowMapping"))) {
      row.append(button(`${typeof entry.key === "number" ? text.split("\n")[0] : words.wide(tree.entries(entry.value).length)} ›`, () => this.go(entry.value!.from), { "data-key": String(entry.key) }));
    } else row.append(this.input(schema, key, text, to, error, label));
    if (typeof entry.key === "number") {
      const at = entry.key;
      const shift = (by: number, sign: string, word: string) => button(sign, () => void this.change(error, to, at + by), { title: word, "aria-label": `${word} ${at + 1}`, className: "remove" });
      label.append(shift(-1, "↑", words.earlier), shift(1, "↓", words.later));
    }
    row.append(remove, element("small", { textContent: about }), error);
    return row;
  }

  private input(schema: Schema, key: Key | undefined, text: string, to: Path, error: HTMLElement, label: HTMLLabelElement): HTMLElement {
    const values = key ? schema.values(key.part) : [];
    const id = `field-${to.join("-").replace(/\W+/g, "_")}`;
    label.htmlFor = id;
    const made = element("input", { id, value: text, spellcheck: false, autocomplete: "off", "data-key": String(to.at(-1)) });
    if (values.length) {
      const list = element("datalist", { id: `${id}-values` }, ...values.map((value) => element("option", { value })));
      made.setAttribute("list", list.id);
      label.append(list);
    }
    made.onchange = () => made.value.trim() !== text && void this.change(error, to, made.value);
    return made;
  }

  private adding(path: Path, keys: Key[], schema: Schema): HTMLElement {
    const name = element("input", { placeholder: words.add, "aria-label": words.add, spellcheck: false, "data-key": "add" });
    const value = element("input", { "aria-label": words.add, spellcheck: false, hidden: true, "data-key": "add value" });
    const about = element("small");
    const error = element("span", { className: "error", role: "alert" });
    const list = element("datalist", { id: "keys" }, ...keys.map((x) => element("option", { value: x.name, textContent: schema.about(x.part).slice(0, 80) })));
    name.setAttribute("list", list.id);
    name.onchange = () => {
      value.hidden = !name.value.trim();
      const key = keys.find((x) => x.name === name.value.trim());
      about.textContent = key ? schema.about(key.part) : "";
      value.focus();
    };
    value.onchange = () => void this.change(error, [...path, name.value.trim()], value.value);
    return element("div", { className: "field add" }, name, value, list, about, error);
  }

  private async change(error: HTMLElement, path: Path, value: string | number | null): Promise<void> {
    error.textContent = await this.edit([{ path, value }]);
  }
}
