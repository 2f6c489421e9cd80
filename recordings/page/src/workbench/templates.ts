// What can be added by menu, and tables pasted from a spreadsheet: each as edits of the text.
import type { Path } from "./api";
import type { Schema } from "./schema";
import type { Tree } from "./tree";

export interface Edit { path: Path; value: string | number | null }
export interface Template { group: string; label: string; edit: (tree: Tree) => Edit }

function free(tree: Tree, path: Path, stem: string): Path {
  const names = new Set(tree.entries(tree.at(path)).map((x) => String(x.key)));
  let n = 1;
  while (names.has(`${stem}${n}`)) n++;
  return [...path, `${stem}${n}`];
}

const named = (group: string, label: string, path: Path, stem: string, value: string): Template => ({
  group, label, edit: (tree) => ({ path: free(tree, path, stem), value }),
});
const stage = (label: string, value: string): Template => ({
  group: "stages", label, edit: (tree) => ({ path: ["actions", tree.entries(tree.at(["actions"])).length], value: `{stage: ${label}, ${value}}` }),
});

export function templates(schema: Schema): Template[] {
  return [
    ...schema.types().map((type) => named("cranes", type, ["cranes"], "crane-", `{type: ${type}, at: 0 m}`)),
    named("block", "lug", ["block", "lugs"], "L", "[0 m, 0 m, 0 m]"),
    named("surroundings", "obstacle", ["obstacles"], "obstacle-", "{box: [4 m, 4 m, 4 m], at: [0 m, 0 m, 2 m]}"),
    {
      group: "rigging", label: "lifting beam", edit: (tree) => {
        const crane = String(tree.entries(tree.at(["cranes"]))[0]?.key ?? "crane");
        const lugs = tree.entries(tree.at(["block", "lugs"])).slice(0, 2).map((x) => x.key);
        return { path: free(tree, ["rig", "loaders"], "loader-"), value: `{hook: ${crane} H1, sling: 10 m, lugs: [${lugs.join(", ")}]}` };
      },
    },
    named("rigging", "sling", ["gear"], "sling-", "{kind: sling, EA: 445 MN, breaking: 6430 kN, diameter: 96 mm}"),
    named("rigging", "shackle", ["gear"], "shackle-", "{kind: shackle, WLL: 150 t, standard: RR-C-271}"),
    stage("take up slack", "all hooks: hoist 0.3 m/min until all slings taut"),
    stage("lift off", "all hooks: hoist 0.3 m/min until lifted"),
    stage("hoist", "all hooks: hoist 3 m/min by 1 m"),
    stage("lower", "all hooks: lower 3 m/min by 1 m"),
    stage("traverse", "trolleys: traverse 10 m/min by 2 m"),
    stage("travel", "cranes: travel 10 m/min by 5 m"),
    stage("wait", "wait: 20 s"),
  ];
}

// Tables that may be pasted where a path ends: their columns behind the name, and the value of a row.
export interface Pasted { columns: string[]; value: (cells: string[], length: string, mass: string) => string }
const list = (cells: string[], unit: string) => `[${cells.map((x) => `${x} ${unit}`).join(", ")}]`;
export const TABLES: Record<string, Pasted> = {
  lugs: { columns: ["x", "y", "z"], value: (c, length) => list(c, length) },
  blocks: {
    columns: ["mass", "length", "width", "height", "x", "y", "z"],
    value: (c, length, mass) => `{mass: ${c[0]} ${mass}, size: ${list(c.slice(1, 4), length)}, at: ${list(c.slice(4, 7), length)}}`,
  },
};

// Rows of a spreadsheet as edits below a path; a sentence for a row that is none. Heads without numbers are left out.
export function pasted(text: string, path: Path, table: Pasted, length: string, mass: string): Edit[] | string {
  const edits: Edit[] = [];
  const rows = text.split(/\r?\n/).filter((x) => x.trim());
  for (const [i, row] of rows.entries()) {
    const cells = row.split(row.includes("\t") ? "\t" : row.includes(";") ? ";" : /[,\s]+/).map((x) => x.trim());
    const numbers = cells.slice(1, 1 + table.columns.length).map((x) => x.replace(/^(-?\d+),(\d+)$/, "$1.$2"));
    if (numbers.length === table.columns.length && numbers.every((x) => x !== "" && Number.isFinite(Number(x)))) {
      edits.push({ path: [...path, cells[0]], value: table.value(numbers, length, mass) });
    } else if (i) return row;
  }
  return edits;
}
