// One page, one recording: the scene, the signals, the stages and the events share one time.
//   #t=41.5 in the address shows that instant;  space: play   arrows: step   1 to 4: views   d: dark   s: speed
import "uplot/dist/uPlot.min.css";
import "./style.css";
import { Charts } from "./charts.js";
import { clock, read } from "./data.js";
import { eventList, factList, ropeTable, stageBar } from "./panel.js";
import { Stage } from "./stage.js";

const el = (id) => document.getElementById(id);
const run = read(JSON.parse(el("run").textContent));
const VIEWS = ["corner", "along", "across", "top"];
let now = run.first;
let playing = false;
let before = 0;

document.title = run.title + " · heavylift";
el("title").textContent = run.title;
el("status").textContent = run.status;
const stage = new Stage(el("stage"), run);
const charts = new Charts(el("charts"), el("picker"), run, jump);
const stages = stageBar(el("stages"), run, jump);
const events = eventList(el("events"), el("all"), run, jump);
ropeTable(el("ropes"), run);
factList(el("facts"), run);

const seek = el("seek");
seek.min = run.first;
seek.max = run.last;

function jump(t) {
  now = Math.min(run.last, Math.max(run.first, t));
  seek.value = now;
  el("clock").textContent = `${clock(now)} / ${clock(run.last)}`;
  el("stage-name").textContent = stages(now);
  events(now);
  charts.cursor(now);
  stage.show(now);
}

function play(on) {
  playing = on;
  el("play").textContent = on ? "❚❚" : "▶";
  el("play").setAttribute("aria-label", on ? "pause" : "play");
  if (on && now >= run.last) jump(run.first);
  before = performance.now();
  if (on) requestAnimationFrame(tick);
}

function tick(at) {
  if (!playing) return;
  const speed = Number(el("speed").value);
  jump(now + (Math.max(0, at - before) / 1e3) * speed);
  before = at;
  if (now >= run.last) play(false);
  else requestAnimationFrame(tick);
}

function paint(theme) {
  document.documentElement.dataset.theme = theme;
  charts.paint(theme);
  stage.paint(theme);
}

const dark = matchMedia("(prefers-color-scheme: dark)");
const toggle = () => paint(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
seek.oninput = () => jump(Number(seek.value));
el("play").onclick = () => play(!playing);
el("theme").onclick = toggle;
el("print").onclick = () => print();
for (const button of document.querySelectorAll("[data-view]")) button.onclick = () => stage.look(button.dataset.view);

const step = () => Math.max(0.1, Number(el("speed").value) / 4);
const KEYS = {
  " ": () => play(!playing),
  ArrowRight: () => jump(now + step()),
  ArrowLeft: () => jump(now - step()),
  Home: () => jump(run.first),
  End: () => jump(run.last),
  d: toggle,
  s: () => (el("speed").selectedIndex = (el("speed").selectedIndex + 1) % el("speed").options.length),
};
VIEWS.forEach((view, i) => (KEYS[i + 1] = () => stage.look(view)));
addEventListener("keydown", (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || e.target.matches("input[type=checkbox], select")) return;
  const act = KEYS[e.key];
  if (act) {
    e.preventDefault();
    act();
  }
});
addEventListener("resize", () => {
  stage.resize();
  charts.resize();
});
addEventListener("hashchange", start);

function start() {
  const wanted = /t=([\d.]+)/.exec(location.hash);
  jump(wanted ? Number(wanted[1]) : run.first);
}

paint(dark.matches ? "dark" : "light");
dark.onchange = () => paint(dark.matches ? "dark" : "light");
stage.resize();
stage.look("corner");
start();
document.documentElement.dataset.ready = "yes";
