// The table of checks: worst first, those of one kind in one row until they are asked for; colours with their words.
import { clock } from "../data.js";
import type { Check, Checks } from "./api";
import { element, markup } from "./dom";
import { stateWords, words } from "./words";

const percent = (x: number | undefined) => (x === undefined || x === null ? "" : `${(100 * x).toFixed(x < 0.1 ? 1 : 0)} %`);

export class CheckTable {
  readonly host = element("section", { id: "checks", "aria-label": words.checks });
  private readonly line = element("p", { id: "verdict", role: "status" });
  private readonly mark = element("span", { className: "mark" });
  private readonly body = element("div", { className: "scroll", tabIndex: 0 });
  private readonly tabs = element("div", { role: "tablist", className: "tabs" });
  private every = false;
  private tab: "checks" | "tables" | "notes" | "runs" = "checks";
  private found: Checks | null = null;

  constructor(private readonly go: (check: Check) => void, private readonly runs: HTMLElement) {
    for (const name of ["checks", "tables", "notes", "runs"] as const) {
      const made = element("button", { type: "button", role: "tab", textContent: words[name], "data-tab": name });
      made.onclick = () => this.open(name);
      this.tabs.append(made);
    }
    const every = element("input", { type: "checkbox" });
    every.onchange = () => {
      this.every = every.checked;
      this.draw();
    };
    const bar = element("div", { className: "bar" }, this.tabs, element("label", {}, every, words.all));
    this.host.append(this.line, this.mark, bar, this.body);
    this.draw();
  }

  open(tab: typeof this.tab): void {
    this.tab = tab;
    this.draw();
  }

  take(found: Checks | null): void {
    this.found = found;
    this.draw();
    if (found) document.documentElement.dataset.checks = found.version;
  }

  get version(): string {
    return this.found?.version ?? "";
  }

  stale(text: string): void {
    this.mark.textContent = text;
    this.host.classList.toggle("stale", !!text);
  }

  private draw(): void {
    for (const tab of this.tabs.querySelectorAll("[role=tab]")) tab.setAttribute("aria-selected", String((tab as HTMLElement).dataset.tab === this.tab));
    const { found } = this;
    this.line.className = found ? `state ${found.state}` : "";
    this.line.textContent = found ? found.line : words.noChecks;
    if (this.tab === "runs") return this.body.replaceChildren(this.runs);
    if (!found) return this.body.replaceChildren();
    if (this.tab === "tables") return this.body.replaceChildren(...found.tables.map((html) => element("div", { className: "table" }, markup(html))));
    if (this.tab === "notes") {
      const told = [...(found.ends ? [words.ends(found.ends)] : []), ...found.notes];
      return this.body.replaceChildren(element("ul", {}, ...told.map((x) => element("li", { textContent: x }))));
    }
    const head = element("tr", {}, ...words.columns.map((x) => element("th", { textContent: x, scope: "col" })));
    this.body.replaceChildren(element("table", {}, element("thead", {}, head), element("tbody", {}, ...this.rows(found.checks))));
  }

  private rows(checks: Check[]): HTMLElement[] {
    const groups = new Map<string, Check[]>();
    checks.forEach((check, i) => {
      const key = this.every ? String(i) : `${check.state} ${check.why} ${check.quantity}`;
      groups.set(key, [...(groups.get(key) ?? []), check]);
    });
    return [...groups.values()].map((group) => this.row(group));
  }

  private row(group: Check[]): HTMLElement {
    const size = (x: Check) => x.use ?? x.value ?? 0;
    const worst = group.reduce((a, b) => (size(b) > size(a) ? b : a));
    const many = new Set(group.map((x) => x.subject)).size;
    const at = [worst.t ? clock(worst.t, 1) : "", worst.stage].filter(Boolean).join(", ");
    const cells = [worst.quantity, worst.subject + (many > 1 ? words.many(many) : ""), worst.shown, worst.allowed, percent(worst.use), at, worst.sentence || worst.basis];
    const word = worst.state === "none" ? stateWords.none : worst.word;
    const row = element("tr", { tabIndex: 0, className: worst.state }, element("td", {}, element("span", { className: `state ${worst.state}`, textContent: word })),
      ...cells.map((x) => element("td", { textContent: x ?? "" })));
    row.onclick = () => this.go(worst);
    row.onkeydown = (e) => e.key === "Enter" && this.go(worst);
    if (worst.use) (row.children[5] as HTMLElement).style.setProperty("--use", `${Math.min(100, 100 * worst.use)}%`);
    return row;
  }
}
