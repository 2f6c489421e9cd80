// Bundles src/ into page.js and curves.js with their .css, which are committed and shipped, so that users need no Node.
import { build } from "esbuild";

await build({
  entryPoints: { page: "src/main.js", curves: "src/curves.js" },
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  legalComments: "inline", // the licences of three.js and uPlot travel with the bundle
  outdir: ".",
});
