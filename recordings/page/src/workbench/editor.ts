// The text of the scene: YAML with the faults of the server, saved by itself when typing pauses; undo for all changes.
import { autocompletion, closeBrackets, closeBracketsKeymap, completionKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab, redo, undo } from "@codemirror/commands";
import { yaml } from "@codemirror/lang-yaml";
import { bracketMatching, foldGutter, HighlightStyle, indentOnInput, indentUnit, syntaxHighlighting } from "@codemirror/language";
import { type Diagnostic, lintGutter, setDiagnostics } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { EditorState, Transaction } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, hoverTooltip, keymap, lineNumbers } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import { api, type Fault, Refused, type Scene } from "./api";
import { button, element } from "./dom";
import type { Schema } from "./schema";
import { completions, explained } from "./complete";
import { Proposal } from "./proposal";
import type { Edit } from "./templates";
import { words } from "./words";

const PAUSE_ms = 350; // without a key until the text is saved

const colours = HighlightStyle.define([
  { tag: tags.comment, class: "tok-comment" },
  { tag: [tags.propertyName, tags.definition(tags.propertyName)], class: "tok-key" },
  { tag: [tags.string, tags.special(tags.string)], class: "tok-string" },
  { tag: [tags.content, tags.literal, tags.number], class: "tok-value" },
]);

export class Editor {
  readonly host = element("section", { id: "editor", "aria-label": words.text });
  readonly view: EditorView;
  schema: Schema | null = null;
  private readonly status = element("span", { className: "status", role: "status" });
  readonly conflict = element("div", { id: "conflict", role: "alert", hidden: true });
  private file = "";
  private base = ""; // version of the file that the text comes from
  private number = 0; // of the message of the scene that came last, or of an own save
  private written: string | null = null; // what is being saved
  private dirty = false;
  private theirs: Scene | null = null;
  private ending = "\n";
  readonly proposal: Proposal;
  readonly tools = element("div", { className: "tools", role: "group", "aria-label": words.changes }, button("↶", () => undo(this.view), { title: words.undo, "aria-label": words.undo }),
    button("↷", () => redo(this.view), { title: words.redo, "aria-label": words.redo }));
  private timer = 0;
  private last: Promise<unknown> = Promise.resolve(); // the edit before

  constructor(private readonly moved: () => void) {
    this.conflict.append(words.conflict, " ", button(words.keepMine, () => this.resolve(true)), button(words.takeTheirs, () => this.resolve(false)));
    this.tools.append(this.status);
    this.proposal = new Proposal(() => this.view, () => {
      this.dirty = true;
      void this.save();
    });
    this.view = new EditorView({ parent: this.host, state: this.fresh("", true) });
    this.view.scrollDOM.tabIndex = 0;
  }

  private fresh(doc: string, locked: boolean): EditorState {
    return EditorState.create({
      doc,
      extensions: [
        lineNumbers(), foldGutter(), history(), drawSelection(), indentOnInput(), bracketMatching(), closeBrackets(), highlightActiveLine(),
        highlightSelectionMatches(), lintGutter(), yaml(), syntaxHighlighting(colours), indentUnit.of("  "),
        autocompletion({ override: [(context) => this.schema && completions(context, this.schema)] }),
        hoverTooltip((view, at) => this.schema && explained(view, at, this.schema)),
        keymap.of([
          { key: "Mod-s", run: () => (void this.save(), true) },
          ...closeBracketsKeymap, ...defaultKeymap, ...searchKeymap, ...historyKeymap, ...completionKeymap, indentWithTab,
        ]),
        EditorState.readOnly.of(locked),
        this.proposal.merge.of([]),
        EditorView.contentAttributes.of({ "aria-label": words.text }),
        EditorView.updateListener.of((update) => {
          if (update.docChanged && !update.transactions.some((x) => x.annotation(Transaction.remote))) this.typed();
          if (update.docChanged || update.selectionSet) this.moved();
          if (update.docChanged) queueMicrotask(() => this.proposal.draw());
        }),
      ],
    });
  }

  get text(): string {
    return this.view.state.doc.toString();
  }

  get lines(): string[] {
    return this.text.split("\n");
  }

  private typed(): void {
    this.dirty = true;
    this.status.textContent = words.unsaved;
    clearTimeout(this.timer);
    if (!this.proposal.on) this.timer = window.setTimeout(() => void this.save(), PAUSE_ms);
  }

  // What stands in the file now.
  take(scene: Scene): void {
    if (scene.number < this.number) return; // it was on its way while something newer was saved
    const text = (scene.text ?? "").replaceAll("\r\n", "\n");
    if (scene.file === this.file && text === this.written) return; // the answer to the save tells its version
    this.number = scene.number;
    this.ending = text === scene.text ? "\n" : "\r\n";
    if (scene.file !== this.file) {
      this.file = scene.file;
      this.accept(scene.version!);
      this.view.setState(this.fresh(text, !scene.own));
      this.proposal.clear();
      this.moved();
      this.status.textContent = scene.own ? "" : words.readOnly;
      return;
    }
    if (scene.version === this.base) return;
    if (text === this.text) this.accept(scene.version!);
    else if (this.dirty) {
      this.theirs = scene;
      this.conflict.hidden = false;
    } else this.put(text, scene.version!);
  }

  private accept(version: string): void {
    this.base = version;
    this.dirty = false;
    this.conflict.hidden = true;
    this.theirs = null;
    this.status.textContent = words.saved;
  }

  // Only what differs is replaced, so that the cursor stays.
  private put(text: string, version: string): void {
    const old = this.text;
    let from = 0;
    while (from < old.length && from < text.length && old[from] === text[from]) from++;
    let end = 0;
    while (end < old.length - from && end < text.length - from && old[old.length - 1 - end] === text[text.length - 1 - end]) end++;
    this.base = version;
    this.conflict.hidden = true;
    this.theirs = null;
    this.view.dispatch({ changes: { from, to: old.length - end, insert: text.slice(from, text.length - end) }, annotations: Transaction.remote.of(true) });
  }

  private resolve(mine: boolean): void {
    const { theirs } = this;
    if (!theirs) return;
    if (!mine) {
      this.dirty = false;
      this.put(theirs.text!.replaceAll("\r\n", "\n"), theirs.version!);
      this.status.textContent = "";
      return;
    }
    this.base = theirs.version!;
    this.conflict.hidden = true;
    this.theirs = null;
    void this.save();
  }

  // Write what has been typed; true if the file has it.
  async save(): Promise<boolean> {
    clearTimeout(this.timer);
    if (this.proposal.on) return false;
    if (!this.dirty || this.theirs) return !this.theirs;
    const text = this.text;
    this.written = text;
    try {
      const { version, number } = await api.save(text.replaceAll("\n", this.ending), this.base);
      if (number < this.number) return !this.theirs; // somebody has changed it since, which is shown already
      this.number = number;
      if (this.text === text) this.accept(version);
      else this.base = version;
      return true;
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      this.status.textContent = error.message;
      return false;
    } finally {
      this.written = null;
    }
  }

  // Change values of the file, one edit after the other, each made of the text as it is then: what has been typed first.
  edit(edits: () => Edit[]): Promise<string> {
    const made = this.last.then(() => this.change(edits));
    this.last = made.catch(() => {});
    return made;
  }

  private async change(edits: () => Edit[]): Promise<string> {
    if (!(await this.save())) return words.conflict;
    try {
      const { text, version, number } = await api.edit(edits(), this.base);
      if (number < this.number) return ""; // what came after it is shown already
      this.number = number;
      if (!this.dirty && this.base !== version) this.put(text.replaceAll("\r\n", "\n"), version);
      return "";
    } catch (error) {
      if (!(error instanceof Refused)) throw error;
      return error.message;
    }
  }

  // Show another text as changes of this one.
  propose(text: string): void {
    if (text === this.text) this.status.textContent = words.same;
    else this.proposal.begin(text);
  }

  mark(faults: Fault[]): void {
    const { doc } = this.view.state;
    const own = this.file.split("/").at(-1);
    const shown: Diagnostic[] = faults.filter((x) => x.file === own && x.line <= doc.lines).map((fault) => {
      const line = doc.line(fault.line);
      const from = Math.min(line.to, line.from + fault.column - 1);
      const word = /^[^\s,\]}]+/.exec(doc.sliceString(from, line.to))?.[0].length ?? 0;
      return { from, to: Math.max(from, Math.min(line.to, from + word)), severity: "error", message: [fault.sentence, fault.hint].filter(Boolean).join(" ") };
    });
    this.view.dispatch(setDiagnostics(this.view.state, shown));
  }

  // Put the cursor on a line; `focus`: to type there.
  go(line: number, column: number, focus = true): void {
    const { doc } = this.view.state;
    if (line > doc.lines) return;
    this.select(Math.min(doc.line(line).to, doc.line(line).from + column - 1));
    if (focus) this.view.focus();
  }

  select(at: number): void {
    this.view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
  }
}
