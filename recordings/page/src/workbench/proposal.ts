// Another text as changes of this one, each to be accepted or refused, in the text and in a list; nothing is saved before.
import { acceptChunk, getChunks, getOriginalDoc, rejectChunk, unifiedMergeView } from "@codemirror/merge";
import { Compartment, type Text, Transaction } from "@codemirror/state";
import type { EditorView } from "@codemirror/view";
import { button, element } from "./dom";
import { words } from "./words";

const lines = (doc: Text, from: number, to: number) => doc.sliceString(from, Math.max(from, to)).split("\n").map((x) => x.trim()).filter(Boolean).join(" · ");

export class Proposal {
  readonly host = element("section", { id: "proposal", "aria-label": words.proposal, hidden: true });
  readonly merge = new Compartment();
  on = false;
  private readonly list = element("ol");

  constructor(private readonly view: () => EditorView, private readonly settled: () => void) {
    this.host.append(element("p", { textContent: words.proposal, role: "status" }), this.list,
      element("div", { className: "buttons" }, button(words.acceptAll, () => this.settle(true), { className: "primary" }), button(words.refuseAll, () => this.settle(false))));
  }

  begin(text: string): void {
    const original = this.view().state.doc;
    this.on = true;
    this.host.hidden = false;
    this.view().dispatch({ effects: this.merge.reconfigure(unifiedMergeView({ original, mergeControls: true })) });
    this.view().dispatch({ changes: { from: 0, to: original.length, insert: text }, annotations: Transaction.remote.of(true) });
    this.draw();
  }

  // The changes that are left.
  draw(): void {
    if (!this.on) return;
    const { state } = this.view();
    const before = getOriginalDoc(state);
    const left = getChunks(state)?.chunks ?? [];
    if (!left.length) return this.end();
    this.list.replaceChildren(...left.map((chunk) => {
      const [old, now] = [lines(before, chunk.fromA, chunk.endA), lines(state.doc, chunk.fromB, chunk.endB)];
      return element("li", {}, old && element("del", { textContent: old }), now && element("ins", { textContent: now }),
        element("span", { className: "buttons" }, button(words.accept, () => this.each(() => acceptChunk(this.view(), chunk.fromB))), button(words.refuse, () => this.each(() => rejectChunk(this.view(), chunk.fromB)))));
    }));
  }

  private each(act: () => void): void {
    act();
    this.draw();
  }

  private settle(accept: boolean): void {
    const { state } = this.view();
    if (!accept) this.view().dispatch({ changes: { from: 0, to: state.doc.length, insert: getOriginalDoc(state).toString() }, annotations: Transaction.remote.of(true) });
    this.end();
  }

  private end(): void {
    this.clear();
    this.view().dispatch({ effects: this.merge.reconfigure([]) });
    this.settled();
  }

  clear(): void {
    this.on = false;
    this.host.hidden = true;
  }
}
