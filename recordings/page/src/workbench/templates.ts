// What can be added by menu, and tables pasted from a spreadsheet: each as edits of the text.
import type { Path } from "./api";
import type { Schema } from "./schema";
import type { Tree } from "./tree";

export interface Edit { path: Path; value: string | number | null }
export interface Template { group: string; label: string; about?: string; edit: (tree: Tree, hooks: string[]) => Edit[]; fits?: (tree: Tree) => boolean }

function free(tree: Tree, path: Path, stem: string): Path {
  const names = new Set(tree.entries(tree.at(path)).map((x) => String(x.key)));
  let n = 1;
  while (names.has(`${stem}${n}`)) n++;
  return [...path, `${stem}${n}`];
}

const named = (group: string, label: string, path: Path, stem: string, value: string): Template => ({
  group, label, edit: (tree) => [{ path: free(tree, path, stem), value }],
});

// The paths of all blocks; that of a first one where there is none.
function blocks(tree: Tree): Path[] {
  const named = tree.entries(tree.at(["blocks"])).map((x): Path => ["blocks", x.key]);
  return tree.at(["block"]) || !named.length ? [["block"], ...named] : named;
}

// So many lugs, and a hook, that nothing hangs on yet; those of the whole text come first.
function unused(tree: Tree, hooks: string[], n: number): { hook: string; lugs: string[] } {
  const rigged = [["rig"], ["rigging"]].map((path) => tree.text(tree.at(path))).join(" ");
  const known = (name: string) => new RegExp(`(^|[^\\w-])${name}([^\\w-]|$)`).test(rigged);
  const all = blocks(tree).map((path) => tree.entries(tree.at([...path, "lugs"])).map((x) => String(x.key)));
  const spare = all.map((lugs) => lugs.filter((x) => !known(x))).find((lugs) => lugs.length >= n);
  const crane = String(tree.entries(tree.at(["cranes"]))[0]?.key ?? "crane");
  let n_hook = 1;
  while (known(`${crane} H${n_hook}`)) n_hook++;
  return { hook: hooks.find((x) => !known(x)) ?? `${crane} H${n_hook}`, lugs: (spare ?? all[0]).slice(0, n) };
}

const hung = (group: string, label: string, path: Path, stem: string, lugs: number, value: (hook: string, lugs: string) => string): Template => ({
  group, label, edit: (tree, hooks) => {
    const found = unused(tree, hooks, lugs);
    return [{ path: free(tree, path, stem), value: value(found.hook, `[${found.lugs.join(", ")}]`) }];
  },
});
const HOOK_m = 6, APART_m = 36; // a gantry crane begins with its first hook over the block, others stand beside it
const SLING = "{breaking: 6430 kN, diameter: 96 mm, termination: resin}";
const stage = (label: string, value: string): Template => ({
  group: "actions", label, edit: (tree) => [{ path: ["actions", tree.entries(tree.at(["actions"])).length], value: `{stage: ${label}, ${value}}` }],
});

const BLOCK = {
  mass: "100 t", size: "[12 m, 8 m, 6 m]", at: "[40 m, 75 m, 5 m]", "supports.height": "2 m", "supports.at": "[[-4 m, -3 m], [4 m, -3 m], [-4 m, 3 m], [4 m, 3 m]]", "supports.capacity": "100 t",
  "lug capacity": "100 t", "lugs.L1": "[-2 m, 0 m, 3.3 m]", "lugs.L2": "[2 m, 0 m, 3.3 m]",
};

// One more block beside the last one, with lugs of names that are free.
function another(tree: Tree): Edit[] {
  const all = blocks(tree), last = all.at(-1)!;
  const numbers = (key: string) => tree.entries(tree.at([...last, key])).map((x) => Number.parseFloat(tree.plain(x.value)));
  const [x = 40, y = 75] = numbers("at"), [, width = 8] = numbers("size");
  const taken = new Set(all.flatMap((path) => tree.entries(tree.at([...path, "lugs"])).map((lug) => String(lug.key))));
  const names = Array.from({ length: taken.size + 2 }, (_, i) => `L${i + 1}`).filter((name) => !taken.has(name));
  const at = `[${x} m, ${y + width / 2 + 6} m, 5 m]`; // a metre beside it
  return Object.entries({ ...BLOCK, size: "[12 m, 10 m, 6 m]", at }).map(([key, value]) => ({
    path: [...free(tree, ["blocks"], "block-"), ...key.replace(/L(\d)$/, (_, n) => names[Number(n) - 1]).split(".")], value,
  }));
}

export function templates(schema: Schema): Template[] {
  const fits = (tree: Tree) => !!tree.at(blocks(tree)[0]); // there is a block already
  return [
    ...schema.types().map(([type, about]): Template => ({
      group: "cranes", label: type, about, edit: (tree) => {
        const x = Number.parseFloat(tree.plain(tree.entries(tree.at([...blocks(tree)[0], "at"]))[0]?.value ?? null)) || 40;
        return [{ path: free(tree, ["cranes"], "crane-"), value: `{type: ${type}, at: ${(type.startsWith("goliath") ? x + HOOK_m : 0) + APART_m * tree.entries(tree.at(["cranes"])).length} m}` }];
      },
    })),
    { group: "block", label: "block", fits: (tree) => !tree.at(["block"]), edit: () => Object.entries(BLOCK).map(([key, value]) => ({ path: ["block", ...key.split(".")], value })) },
    ...["block", "blocks"].flatMap((group): Template[] => [
      { group, label: "lug", fits, edit: (tree) => [{ path: free(tree, [...blocks(tree)[0], "lugs"], "L"), value: "[0 m, 0 m, 0 m]" }] },
      {
        group, label: "support", fits, edit: (tree) => {
          const path = [...blocks(tree)[0], "supports", "at"];
          return [{ path: [...path, tree.entries(tree.at(path)).length], value: "[0 m, 0 m]" }];
        },
      },
      { group, label: "another block", fits, edit: another },
    ]),
    named("obstacles", "box", ["obstacles"], "obstacle-", "{box: [4 m, 4 m, 4 m], at: [0 m, 0 m, 2 m]}"),
    named("obstacles", "stand", ["obstacles"], "stand-", "{box: [4 m, 20 m, 3 m], at: [0 m, 0 m, 1.5 m], friction: 0.3, meets: lower corners}"),
    hung("rig", "lifting beam", ["rig", "loaders"], "loader-", 2, (hook, lugs) => `{hook: ${hook}, sling: 10 m, lugs: ${lugs}, capacity: 300 t}`),
    { group: "rig", label: "sling of all beams", fits: (tree) => !tree.at(["rig", "sling"]), edit: () => [{ path: ["rig", "sling"], value: SLING }] },
    { group: "rig", label: "shackle of all beams", fits: (tree) => !tree.at(["rig", "shackle"]), edit: () => [{ path: ["rig", "shackle"], value: "150 t" }] },
    hung("rigging", "slings", ["rigging"], "slings-", 4, (hook, lugs) => `{on: ${hook}, to: ${lugs}, length: 10 m, sling: ${SLING}, shackle: 150 t}`),
    named("rigging", "spreader", ["rigging"], "spreader-", "{type: spreader, mass: 5 t, size: [12 m, 0.6 m, 0.6 m]}"),
    named("gear", "sling", ["gear"], "sling-", "{kind: sling, EA: 445 MN, breaking: 6430 kN, diameter: 96 mm, termination: resin}"),
    named("gear", "shackle", ["gear"], "shackle-", "{kind: shackle, WLL: 150 t, standard: RR-C-271}"),
    named("gear", "frame", ["gear"], "frame-", "{kind: spreader, WLL: 200 t, mass: 5 t, size: [12 m, 0.6 m, 0.6 m]}"),
    stage("take up slack", "all hooks: hoist 0.3 m/min until all slings taut"),
    stage("lift off", "all hooks: hoist 0.3 m/min until lifted"),
    stage("hoist", "all hooks: hoist 3 m/min by 1 m"),
    stage("lower", "all hooks: lower 3 m/min by 1 m"),
    stage("set down", "all hooks: lower 0.5 m/min until landed"),
    stage("slack off", "all hooks: lower 0.5 m/min until all slings slack"),
    stage("traverse", "trolleys: traverse 10 m/min by 2 m"),
    stage("travel", "cranes: travel 10 m/min by 5 m"),
    stage("wait", "wait: 20 s"),
  ];
}

// Tables that may be pasted where a path ends: their columns behind the name, and the edits of all rows.
interface PastedRow { name: string; cells: string[] }
export interface Pasted { columns: string[]; named?: boolean; edits: (path: Path, rows: PastedRow[], length: string, mass: string) => Edit[] } // named: each row is an entry of its own
const list = (cells: string[], unit: string) => `[${cells.map((x) => `${x} ${unit}`).join(", ")}]`;
export const TABLES: Record<string, Pasted> = {
  lugs: { columns: ["x", "y", "z"], named: true, edits: (path, rows, length) => rows.map(({ name, cells }) => ({ path: [...path, name], value: list(cells, length) })) },
  supports: { columns: ["x", "y"], edits: (path, rows, length) => [{ path: [...path, "at"], value: `[${rows.map((x) => list(x.cells, length)).join(", ")}]` }] },
  block: {
    columns: ["mass", "length", "width", "height"],
    edits: (path, [{ cells: [heavy, ...sides] }], length, mass) => [{ path: [...path, "mass"], value: `${heavy} ${mass}` }, { path: [...path, "size"], value: list(sides, length) }],
  },
  blocks: {
    columns: ["mass", "length", "width", "height", "x", "y", "z"], named: true,
    edits: (path, rows, length, mass) => rows.map(({ name, cells: c }) => ({
      path: [...path, name], value: `{mass: ${c[0]} ${mass}, size: ${list(c.slice(1, 4), length)}, at: ${list(c.slice(4, 7), length)}}`,
    })),
  },
};

// Rows of a spreadsheet as edits below a path; a sentence for a row that is none. Heads without numbers are left out.
export function pasted(text: string, path: Path, table: Pasted, length: string, mass: string): Edit[] | string {
  const found: PastedRow[] = [];
  const rows = text.split(/\r?\n/).filter((x) => x.trim());
  for (const [i, row] of rows.entries()) {
    const cells = row.split(row.includes("\t") ? "\t" : row.includes(";") ? ";" : /[,\s]+/).map((x) => x.trim());
    const numbers = cells.slice(1, 1 + table.columns.length).map((x) => x.replace(/^(-?\d+),(\d+)$/, "$1.$2"));
    if (numbers.length === table.columns.length && numbers.every((x) => x !== "" && Number.isFinite(Number(x)))) found.push({ name: cells[0], cells: numbers });
    else if (i) return row;
  }
  return found.length ? table.edits(path, found, length, mass) : [];
}
