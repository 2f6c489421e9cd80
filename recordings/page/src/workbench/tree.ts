// The scene's text as a tree of keys: which path a place has, and what is written at a path.
import { ensureSyntaxTree, syntaxTree } from "@codemirror/language";
import type { EditorState } from "@codemirror/state";
import type { SyntaxNode } from "@lezer/common";
import type { Path } from "./api";

const PATIENCE_ms = 10_000; // a tree of half the text would lead edits to wrong places
const COLLECTIONS = ["BlockMapping", "FlowMapping", "BlockSequence", "FlowSequence"];

export interface Entry { key: string | number; value: SyntaxNode | null; node: SyntaxNode }

const unquoted = (text: string) => text.replace(/^(['"])(.*)\1$/s, "$2").trim();

function children(node: SyntaxNode): SyntaxNode[] {
  const found: SyntaxNode[] = [];
  for (let x = node.firstChild; x; x = x.nextSibling) found.push(x);
  return found;
}

// The value behind anchors and tags.
function bare(node: SyntaxNode | null): SyntaxNode | null {
  if (node && ["Anchored", "Tagged"].includes(node.name)) return bare(children(node).at(-1) ?? null);
  return node;
}

export class Tree {
  readonly root: SyntaxNode | null;

  constructor(private readonly state: EditorState) {
    const top = (ensureSyntaxTree(state, state.doc.length, PATIENCE_ms) ?? syntaxTree(state)).topNode;
    this.root = bare(top.getChild("Document")?.getChild("BlockMapping") ?? null);
  }

  text(node: SyntaxNode | null): string {
    return node ? this.state.sliceDoc(node.from, node.to).trimEnd() : "";
  }

  // A value without its quotes.
  plain(node: SyntaxNode | null): string {
    return unquoted(this.text(node));
  }

  entries(node: SyntaxNode | null): Entry[] {
    if (!node) return [];
    if (node.name.endsWith("Mapping")) {
      return children(node).filter((x) => x.name === "Pair").map((pair) => ({
        key: unquoted(this.text(pair.getChild("Key"))), node: pair,
        value: bare(children(pair).find((x) => !["Key", ":", "?", "Comment"].includes(x.name)) ?? null),
      }));
    }
    if (node.name.endsWith("Sequence")) {
      return children(node).filter((x) => x.name === "Item").map((item, i) => ({
        key: i, node: item, value: bare(children(item).find((x) => !["-", "Comment"].includes(x.name)) ?? null),
      }));
    }
    return [];
  }

  at(path: Path): SyntaxNode | null {
    return path.reduce<SyntaxNode | null>((node, key) => this.entries(node).find((x) => x.key === key)?.value ?? null, this.root);
  }

  // The path of the key or value at a place.
  path(at: number): Path {
    const found: Path = [];
    let node = this.root;
    for (;;) {
      const entry = this.entries(node).find((x) => x.node.from <= at && at <= x.node.to);
      if (!entry) return found;
      found.push(entry.key);
      node = entry.value;
    }
  }

  type(path: Path): string {
    return this.plain(this.at([...path, "type"]));
  }

  collection(node: SyntaxNode | null): boolean {
    return !!node && COLLECTIONS.includes(node.name);
  }
}
