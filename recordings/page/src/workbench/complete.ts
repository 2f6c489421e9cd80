// What the schema knows while one types: keys and values that may follow, and what a key means.
import type { CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import type { EditorView, Tooltip } from "@codemirror/view";
import type { Path } from "./api";
import { element } from "./dom";
import type { Schema } from "./schema";
import { Tree } from "./tree";

// The mapping that a line of block style belongs to, by indentation, for a line that is no YAML yet.
function above(lines: string[], line: number, column: number): Path {
  const found: Path = [];
  let indent = column;
  for (let i = line - 1; i >= 0 && indent > 0; i--) {
    const match = /^(\s*)((?:- )*)([^\s#:][^:#]*):(\s|$)/.exec(lines[i]);
    const dashed = /^(\s*)- /.exec(lines[i]);
    if (match && match[1].length + match[2].length < indent) {
      found.unshift(match[3].trim().replace(/^(['"])(.*)\1$/, "$2"));
      indent = match[1].length + match[2].length;
    }
    if (dashed && dashed[1].length < indent && indent > dashed[1].length) {
      let number = 0;
      for (let j = i - 1; j >= 0 && (lines[j].startsWith(dashed[1]) || !lines[j].trim()); j--) {
        if (lines[j].startsWith(`${dashed[1]}- `)) number++;
        else if (lines[j].trim() && !lines[j].startsWith(`${dashed[1]} `)) break;
      }
      found.unshift(number);
      indent = dashed[1].length + (dashed[1].length === 0 ? 0 : 0);
      const parent = /^(\s*)([^\s#:-][^:#]*):\s*(#.*)?$/;
      for (let j = i - 1; j >= 0; j--) {
        const key = parent.exec(lines[j]);
        if (key && key[1].length <= indent) {
          found.unshift(key[2].trim());
          indent = key[1].length;
          i = j;
          break;
        }
      }
    }
  }
  return found;
}

export function completions(context: CompletionContext, schema: Schema): CompletionResult | null {
  const { state, pos } = context;
  const line = state.doc.lineAt(pos);
  const before = line.text.slice(0, pos - line.from);
  const typed = /[\w'" -]*$/.exec(before)![0].trimStart();
  const tree = new Tree(state);
  const typeAt = (path: Path) => tree.type(path);
  const open = Math.max(before.lastIndexOf("{"), before.lastIndexOf("["));
  const flow = open > Math.max(before.lastIndexOf("}"), before.lastIndexOf("]"));
  const key = /^(\s*(?:- )*)([^:{[]*)$/.exec(before);
  const base = flow ? tree.path(line.from + open) : above(state.doc.toString().split("\n"), line.number - 1, key ? key[1].length : /^(\s*(?:- )*)/.exec(before)![1].length);
  const valued = /([\w'" -]+):\s*([^,{}[\]]*)$/.exec(flow ? before.slice(open + 1) : before.trimStart().replace(/^(- )+/, ""));
  if (valued) {
    const part = schema.keys(schema.at(base, typeAt)).find((x) => x.name === valued[1].trim())?.part;
    const values = part ? schema.values(part) : [];
    return values.length ? { from: pos - valued[2].length, options: values.map((label) => ({ label, type: "constant" })) } : null;
  }
  if (!context.explicit && !typed) return null;
  const written = new Set(tree.entries(tree.at(base)).map((x) => x.key));
  const options = schema.keys(schema.at(base, typeAt)).filter((x) => !written.has(x.name)).map(({ name, part, required }) => ({
    label: name, apply: `${name}: `, type: "property", detail: required ? "required" : "", info: schema.about(part), boost: required ? 1 : 0,
  }));
  return options.length ? { from: pos - typed.length, options, validFor: /^[\w -]*$/ } : null;
}

export function explained(view: EditorView, at: number, schema: Schema): Tooltip | null {
  const tree = new Tree(view.state);
  const path = tree.path(at);
  const key = path.at(-1);
  if (typeof key !== "string") return null;
  const part = schema.keys(schema.at(path.slice(0, -1), (p) => tree.type(p))).find((x) => x.name === key)?.part;
  const text = part && schema.about(part);
  if (!text) return null;
  return { pos: at, above: true, create: () => ({ dom: element("div", { className: "about" }, element("b", { textContent: key }), ` ${text}`) }) };
}
