// The scene as a tree of what it is made of: a click shows its form and its place in the text, + adds one of its kind.
import type { Path } from "./api";
import { button, choice, element, option } from "./dom";
import type { Template } from "./templates";
import type { Tree } from "./tree";
import { words } from "./words";

const SHOWN = ["block", "blocks", "cranes", "rig", "rigging", "gear", "obstacles", "actions", "limits", "factors"];
const OFFERED = ["block", "cranes", "rig", "rigging", "gear", "obstacles", "actions", "limits"]; // also where nothing is written of them yet
const FLAT = ["limits", "factors", "wind", "waves", "current", "floor", "ground", "fidelity", "project", "parameters"]; // whose entries are fields of one form
const LEAVES = ["name", "heavylift", "project", "practice", "accuracy", "ask", "end", "samples", "seed", "assumed", "method", "step", "tolerance", "gravity"];

interface Row { path: Path; text: string; detail: string; rows: Row[] }

export class Outline {
  readonly host = element("nav", { id: "outline", "aria-label": words.outline });
  private readonly closed = new Set<string>();
  private shown = "";

  constructor(private readonly go: (path: Path) => void, private readonly add: (template: Template) => void) {}

  show(tree: Tree, at: Path, templates: Template[], faults: string[]): void {
    const rows = this.rows(tree);
    const now = JSON.stringify([rows, at, templates.length, faults, [...this.closed]]);
    if (now === this.shown) return;
    this.shown = now;
    const focus = (document.activeElement as HTMLElement | null)?.closest<HTMLElement>("#outline [data-path]")?.dataset.path;
    const redraw = () => this.show(tree, at, templates, faults);
    this.host.replaceChildren(element("ul", {}, ...rows.map((row) => this.item(tree, row, at, templates, faults, redraw))));
    if (focus) this.host.querySelector<HTMLElement>(`[data-path="${CSS.escape(focus)}"]`)?.focus();
    this.host.querySelector("[aria-current]")?.scrollIntoView({ block: "nearest" });
  }

  private item(tree: Tree, row: Row, at: Path, templates: Template[], faults: string[], redraw: () => void): HTMLElement {
    const key = row.path.join(".");
    const open = !this.closed.has(key);
    const here = row.path.join() === at.slice(0, row.path.length).join() && (row.path.length > 0 || !at.length || LEAVES.includes(String(at[0])));
    const inner = row.rows.some((x) => x.path.join() === at.slice(0, x.path.length).join());
    const bad = faults.some((x) => x === key || x.startsWith(`${key}.`) || x.startsWith(`${key}[`));
    const toggle = button(open ? "▾" : "▸", () => {
      if (open) this.closed.add(key);
      else this.closed.delete(key);
      redraw();
    }, { className: "toggle", "aria-expanded": String(open), "aria-label": words.unfold(row.text) });
    const label = button("", () => this.go(row.path), { className: `label${row.rows.length || row.detail ? "" : " empty"}${bad ? " bad" : ""}`, "data-path": key });
    label.append(element("span", { textContent: row.text }), row.detail && element("small", { textContent: row.detail }));
    if (here && !(inner && open)) label.setAttribute("aria-current", "true");
    const own = row.path.length === 1 ? templates.filter((x) => x.group === row.path[0] && (x.fits?.(tree) ?? true)) : [];
    const add = own.length ? choice(words.addTo(row.text), [option("", "+"), ...own.map((x, i) => option(String(i), x.about ? `${x.label}: ${x.about}` : x.label))], (value) => {
      add!.value = "";
      this.add(own[Number(value)]);
    }, { className: "plus" }) : null;
    return element("li", {}, element("div", { className: `line${row.path.length < 2 ? " group" : ""}` }, row.rows.length ? toggle : element("i", { className: "toggle" }), label, add),
      row.rows.length && open ? element("ul", {}, ...row.rows.map((x) => this.item(tree, x, at, templates, faults, redraw))) : null);
  }

  private rows(tree: Tree): Row[] {
    const written = tree.entries(tree.root).map((x) => String(x.key));
    const found: Row[] = [{ path: [], text: words.top, detail: tree.plain(tree.at(["name"])), rows: [] }];
    const others = written.filter((x) => !SHOWN.includes(x) && !LEAVES.includes(x));
    for (const key of [...SHOWN.filter((x) => written.includes(x) || (OFFERED.includes(x) && !(x === "block" && written.includes("blocks")))), ...others]) {
      const rows = this.below(tree, [key]);
      found.push({ path: [key], text: words.parts[key] ?? key, detail: key === "block" ? tree.plain(tree.at(["block", "mass"])) : rows.length > 1 ? String(rows.length) : "", rows });
    }
    return found;
  }

  private below(tree: Tree, path: Path): Row[] {
    const node = tree.at(path);
    const top = String(path[0]);
    if (FLAT.includes(top)) return [];
    const deep = path.length > 1;
    return tree.entries(node).flatMap((entry): Row[] => {
      const to = [...path, entry.key];
      if (typeof entry.key === "number") {
        if (top !== "actions" || deep) return [];
        const name = tree.plain(tree.at([...to, "stage"])) || tree.text(entry.value).split("\n")[0];
        return [{ path: to, text: `${entry.key + 1}  ${name}`, detail: "", rows: [] }];
      }
      if (top === "block" || top === "rig" || (top === "blocks" && deep)) {
        if (!tree.collection(entry.value) || tree.entries(entry.value).every((x) => typeof x.key === "number")) return [];
        const rows = top === "rig" && entry.key === "loaders" ? this.named(tree, to) : [];
        return [{ path: to, text: words.parts[entry.key] ?? entry.key, detail: entry.key === "lugs" ? String(tree.entries(entry.value).length) : "", rows }];
      }
      return tree.collection(entry.value) ? [{ path: to, text: entry.key, detail: tree.type(to), rows: top === "blocks" ? this.below(tree, to) : [] }] : [];
    });
  }

  private named(tree: Tree, path: Path): Row[] {
    return tree.entries(tree.at(path)).map((x) => ({ path: [...path, x.key], text: String(x.key), detail: tree.plain(tree.at([...path, x.key, "hook"])), rows: [] }));
  }
}
