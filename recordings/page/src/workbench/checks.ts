// The table of checks: worst first, those of one kind in one row until they are asked for; colours with their words.
import { clock } from "../data.js";
import type { Check, Checks, Near } from "./api";
import { button, element, markup } from "./dom";
import { chip } from "./runs";
import { words } from "./words";

const size = (x: Check) => x.use ?? x.value ?? 0;
const percent = (x: number | undefined) => (x === undefined || x === null ? "" : `${(100 * x).toFixed(x < 0.1 ? 1 : 0)} %`);

type Tab = "checks" | "tables" | "notes" | "runs" | "studies";

export class CheckTable {
  readonly host = element("section", { id: "checks", "aria-label": words.checks });
  private readonly line = element("p", { id: "verdict", role: "status" });
  private readonly mark = element("span", { className: "mark" });
  private readonly body = element("div", { className: "scroll", tabIndex: 0, role: "tabpanel", id: "panel" });
  private readonly tabs = element("div", { role: "tablist", className: "tabs", "aria-label": words.results });
  private readonly everyLabel: HTMLElement;
  private every = false;
  private tab: Tab = "checks";
  private rest: Checks | null = null; // of the path at rest
  private run: Checks | null = null; // of the run that is played
  private of = "";

  constructor(private readonly go: (check: Check) => void, private readonly accept: () => void, private readonly panels: Record<"runs" | "studies", HTMLElement>) {
    for (const name of ["checks", "tables", "notes", "runs", "studies"] as const) {
      const made = element("button", { type: "button", role: "tab", textContent: words.tabs[name], "data-tab": name, "aria-controls": "panel" });
      made.onclick = () => this.open(name);
      made.onkeydown = (e) => {
        const next = e.key === "ArrowRight" ? made.nextElementSibling : e.key === "ArrowLeft" ? made.previousElementSibling : null;
        (next as HTMLElement | null)?.focus();
        (next as HTMLElement | null)?.click();
      };
      this.tabs.append(made);
    }
    const every = element("input", { type: "checkbox" });
    every.onchange = () => {
      this.every = every.checked;
      this.draw();
    };
    this.everyLabel = element("label", {}, every, words.all);
    this.host.append(element("div", { className: "bar" }, this.tabs, this.everyLabel), this.line, this.mark, this.body);
    this.draw();
  }

  open(tab: Tab): void {
    this.tab = tab;
    this.draw();
    this.body.scrollTop = 0;
  }

  take(found: Checks | null): void {
    this.rest = found;
    this.draw();
    if (found) document.documentElement.dataset.checks = found.version;
  }

  // The verdict of a run in place of that of the path at rest; null: back to it.
  judge(found: Checks | null, of: string): void {
    Object.assign(this, { run: found, of });
    this.draw();
  }

  get near(): Near[] {
    return this.run?.near ?? [];
  }

  get version(): string {
    return this.rest?.version ?? "";
  }

  stale(text: string): void {
    this.mark.textContent = this.of ? "" : text;
    this.host.classList.toggle("stale", !!text && !this.of);
  }

  private draw(): void {
    for (const tab of this.tabs.querySelectorAll<HTMLElement>("[role=tab]")) {
      tab.setAttribute("aria-selected", String(tab.dataset.tab === this.tab));
      tab.tabIndex = tab.dataset.tab === this.tab ? 0 : -1;
    }
    this.everyLabel.hidden = this.tab !== "checks";
    const found = this.of ? this.run : this.rest;
    this.line.className = found ? `state ${found.state}` : "";
    this.line.textContent = found ? (this.of ? words.verdictOf(this.of, found.line) : found.line) : this.of ? words.noVerdict(this.of) : words.noChecks;
    if (this.tab === "runs" || this.tab === "studies") return this.body.replaceChildren(this.panels[this.tab]);
    if (!found) return this.body.replaceChildren();
    if (this.tab === "tables") return this.body.replaceChildren(...found.tables.map((html) => element("div", { className: "table" }, markup(html))));
    if (this.tab === "notes") {
      const told = [...(found.ends ? [words.ends(found.ends)] : []), ...found.notes];
      return this.body.replaceChildren(told.length ? element("ul", {}, ...told.map((x) => element("li", { textContent: x }))) : element("p", { className: "quiet", textContent: words.noNotes }));
    }
    const head = element("tr", {}, ...words.columns.map((x) => element("th", { textContent: x, scope: "col" })));
    this.body.replaceChildren(element("table", { className: "list" }, element("thead", {}, head), element("tbody", {}, ...this.rows(found.checks))));
  }

  private rows(checks: Check[]): HTMLElement[] {
    const groups = new Map<string, Check[]>();
    checks.forEach((check, i) => {
      const key = this.every ? String(i) : `${check.state} ${check.why} ${check.quantity}`;
      groups.set(key, [...(groups.get(key) ?? []), check]);
    });
    const states = [...new Set(checks.map((x) => x.state))]; // worst first, as the verdict has them
    return [...groups.values()].map((group): [Check[], Check] => [group, group.reduce((a, b) => (size(b) > size(a) ? b : a))])
      .sort(([, a], [, b]) => states.indexOf(a.state) - states.indexOf(b.state) || Number(b.load) - Number(a.load) || (b.use ?? 0) - (a.use ?? 0)).map(([group, worst]) => this.row(group, worst));
  }

  private row(group: Check[], worst: Check): HTMLElement {
    const many = new Set(group.map((x) => x.subject)).size;
    const at = [worst.t ? clock(worst.t, 1) : "", worst.stage].filter(Boolean).join(", ");
    const cells = [worst.quantity, worst.subject + (many > 1 ? words.many(many) : ""), worst.shown, worst.allowed, percent(worst.use), at, worst.sentence || worst.basis];
    const word = worst.state === "none" ? worst.why || words.notApplicable : worst.word;
    const row = element("tr", { tabIndex: 0, className: worst.state }, element("td", {}, Object.assign(chip(worst.state), { textContent: word })),
      ...cells.map((x) => element("td", { textContent: x ?? "" })));
    if (worst.why === "assumed") row.lastElementChild!.append(" ", button(words.acceptAssumed, this.accept, { title: words.acceptHelp }));
    row.onclick = () => {
      for (const other of this.body.querySelectorAll("tr.on")) other.classList.remove("on");
      row.classList.add("on");
      this.go(worst);
    };
    row.onkeydown = (e) => e.key === "Enter" && row.click();
    if (worst.use) (row.children[5] as HTMLElement).style.setProperty("--use", `${Math.min(100, 100 * worst.use)}%`);
    return row;
  }
}
