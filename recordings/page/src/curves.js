// A page of curves: one chart per panel, a common cursor and a common time, limits dashed, stages shaded.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import "./curves.css";
import { clock, numbers, timeAxis } from "./data.js";

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#6b7682", "#7a6fd0"];
const LIMIT = "#d0342c";
const figure = JSON.parse(document.getElementById("run").textContent);
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const ink = dark ? "#c7d1db" : "#33404d";
const rule = dark ? "#2b3640" : "#e1e6eb";
const charts = [];

const drawable = (text, Kind) => Array.from(numbers(text, Kind), (x) => (Number.isFinite(x) ? x : null));

function shade(plot) {
  const { ctx, bbox } = plot;
  const last = plot.data[0][plot.data[0].length - 1];
  ctx.save();
  ctx.fillStyle = dark ? "#ffffff0a" : "#0000000a";
  figure.stages.forEach((stage, i) => {
    if (i % 2) return;
    const x0 = Math.max(bbox.left, plot.valToPos(stage.t, "x", true));
    const x1 = Math.min(bbox.left + bbox.width, plot.valToPos(figure.stages[i + 1]?.t ?? last, "x", true));
    if (x1 > x0) ctx.fillRect(x0, bbox.top, x1 - x0, bbox.height);
  });
  ctx.restore();
}

// The stage at the cursor, under each chart.
function named(plot) {
  const t = plot.cursor.idx == null ? null : plot.data[0][plot.cursor.idx];
  const stage = figure.stages.filter((s) => t !== null && s.t <= t).at(-1);
  document.querySelector("p").textContent = stage ? `${clock(t, 2)} ${stage.name}` : "drag zooms, double click resets";
}

function chart(panel) {
  const tables = panel.times.map((t, i) => [
    drawable(t, Float64Array),
    ...panel.curves.filter((c) => c.times === i).map((c) => drawable(c.y, Float32Array)),
  ]);
  const curves = panel.times.flatMap((_, i) => panel.curves.filter((c) => c.times === i));
  const data = tables.length > 1 ? uPlot.join(tables) : tables[0];
  const levels = [...new Set(panel.limits.map((limit) => limit.y))];
  const axis = { stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule } };
  const options = {
    title: panel.title || `[${panel.unit}]`, width: document.body.clientWidth - 24, height: 320,
    scales: { x: { time: false } },
    cursor: { sync: { key: "run" }, drag: { x: true, y: false } },
    hooks: { drawClear: [shade], setCursor: [named], setScale: [zoomed] },
    series: [
      { label: "time", value: (plot, t) => (t === null ? "" : clock(t, 2)) },
      ...curves.map((c) => ({ label: c.name, stroke: COLOURS[c.colour % COLOURS.length], dash: c.dashed ? [5, 4] : [], width: 1.4, spanGaps: true })),
      ...levels.map((y) => ({ label: `rated ${+y.toPrecision(4)} ${panel.unit}`, stroke: LIMIT, dash: [8, 5], width: 1 })),
    ],
    axes: [{ ...axis, ...timeAxis }, { ...axis, size: 70, label: `[${panel.unit}]` }],
  };
  return new uPlot(options, [...data, ...levels.map((y) => data[0].map(() => y))], document.querySelector("main"));
}

let zooming = false;
function zoomed(plot, key) {
  if (key !== "x" || zooming) return;
  zooming = true;
  const { min, max } = plot.scales.x;
  for (const other of charts) if (other !== plot) other.setScale("x", { min, max });
  zooming = false;
}

document.title = document.querySelector("h1").textContent = figure.title;
for (const panel of figure.panels) charts.push(chart(panel));
addEventListener("resize", () => charts.forEach((c) => c.setSize({ width: document.body.clientWidth - 24, height: 320 })));
document.body.dataset.ready = String(charts.length);
