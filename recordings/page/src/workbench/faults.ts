// Faults of the text, each with its line and a caret at its place.
import type { Fault } from "./api";
import { element } from "./dom";
import { words } from "./words";

export class FaultList {
  readonly host = element("section", { id: "faults", "aria-label": words.faults(2), role: "status" });
  faults: Fault[] = [];

  constructor(private readonly go: (fault: Fault) => void) {}

  // `lines`: of the text on the desk, which faults of other files are not in.
  take(faults: Fault[], lines: string[], file: string): void {
    this.faults = faults;
    this.host.replaceChildren(...faults.map((fault) => {
      const own = fault.file === file.split("/").at(-1);
      const text = own ? (lines[fault.line - 1] ?? "") : "";
      const place = `${own ? "" : `${fault.file}, `}${words.line(fault.line)}`;
      const made = element("button", { type: "button" }, element("b", { textContent: place }), ` ${fault.path && fault.path !== "scene" ? `${fault.path}: ` : ""}${fault.sentence}`);
      if (text) made.append(element("pre", { textContent: `${text}\n${" ".repeat(fault.column - 1)}^ ${fault.hint}` }));
      made.onclick = () => this.go(fault);
      return made;
    }));
    document.documentElement.dataset.faults = String(faults.length);
  }
}
