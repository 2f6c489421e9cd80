// Bundles src/ into page.js, curves.js and workbench.js with their .css, which are committed and shipped, so that users
// need no Node.
import { readFile, writeFile } from "node:fs/promises";
import { build } from "esbuild";

const made = await build({
  entryPoints: { page: "src/main.js", curves: "src/curves.js", workbench: "src/workbench/main.ts" },
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "inline", // the licences of three.js and uPlot travel with the bundle
  outdir: ".",
  metafile: true,
});

// So do those of packages whose files do not carry them.
const packages = [...new Set(Object.keys(made.metafile.outputs["workbench.js"].inputs).flatMap((x) => /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(x)?.[1] ?? []))];
const licences = new Map();
for (const name of packages.filter((x) => !["three", "uplot"].includes(x)).sort()) {
  const text = (await readFile(`node_modules/${name}/LICENSE`, "utf8")).trim();
  licences.set(text, [...(licences.get(text) ?? []), name]);
}
const told = [...licences].map(([text, names]) => `/*! ${names.join(", ")}:\n${text}\n*/\n`).join("");
await writeFile("workbench.js", (await readFile("workbench.js", "utf8")) + told);
