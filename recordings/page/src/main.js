// One page, one run: the scene, the signals, the stages and the events share one time.
//   #t=41.5 in the address shows that instant, #t=41.5&view=top&theme=dark more of its state
import "uplot/dist/uPlot.min.css";
import "./style.css";
import { Charts } from "./charts.js";
import { Run } from "./data.js";
import { keyboard } from "./keys.js";
import { listen } from "./live.js";
import { EventList, StageBar, factList, ropeTable } from "./panel.js";
import { Player } from "./player.js";
import { Stage } from "./stage.js";

const GROW_ms = 250; // how often charts and lists of a run that goes on are drawn anew
const el = (id) => document.getElementById(id);
const given = JSON.parse(el("run").textContent);
const root = document.documentElement;

function open(run) {
  document.title = run.title + " · heavylift";
  el("title").textContent = run.title;
  const stage = new Stage(el("stage"), run);
  const player = new Player(run, show);
  const jump = (t) => player.jump(t);
  const charts = new Charts(el("charts"), el("picker"), run, jump);
  const stages = new StageBar(el("stages"), el("timetable"), run, jump);
  const events = new EventList(el("events"), el("all"), run, jump);
  const seek = el("seek");
  const speed = el("speed");
  el("use").hidden = !Object.keys(run.rated).length;

  function show(now) {
    seek.max = run.last;
    seek.min = run.first;
    seek.value = now;
    el("clock").textContent = `${run.clock(now)} / ${run.clock(run.last)}`;
    el("stage-name").textContent = stages.show(now);
    events.show(now);
    charts.cursor(now);
    stage.show(now);
  }

  function tell() {
    el("status").textContent = run.status;
    factList(el("facts"), run);
    ropeTable(el("ropes"), run);
  }

  function paint(theme) {
    root.dataset.theme = theme;
    charts.paint(theme);
    stage.paint(theme);
  }

  function resize() {
    stage.resize();
    charts.resize();
  }

  function start() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    if (wanted.has("theme")) paint(wanted.get("theme") === "dark" ? "dark" : "light");
    if (wanted.has("view")) stage.look(wanted.get("view"));
    jump(Number(wanted.get("t") ?? run.first));
  }

  const dark = matchMedia("(prefers-color-scheme: dark)");
  const toggle = () => paint(root.dataset.theme === "dark" ? "light" : "dark");
  player.onchange = () => {
    el("play").textContent = player.playing ? "❚❚" : "▶";
    el("play").setAttribute("aria-label", player.playing ? "pause" : "play");
    el("follow").classList.toggle("on", player.following);
  };
  seek.oninput = () => {
    player.follow(false);
    jump(Number(seek.value));
  };
  speed.onchange = () => (player.speed = Number(speed.value));
  speed.onchange();
  el("play").onclick = () => player.play(!player.playing);
  el("follow").onclick = () => player.follow(!player.following);
  el("theme").onclick = toggle;
  el("print").onclick = () => print();
  for (const button of document.querySelectorAll("[data-view]")) button.onclick = () => stage.look(button.dataset.view);
  el("ask").onclick = () => el("help").showModal();
  let before = "";
  addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    paint("light");
    el("printed").src = stage.picture(told());
  });
  addEventListener("afterprint", () => paint(before));
  addEventListener("resize", resize);
  addEventListener("hashchange", start);
  dark.onchange = () => paint(dark.matches ? "dark" : "light");

  const told = () => `${run.title}, ${el("stage-name").textContent}, ${run.clock(player.now)}`;
  const save = () => {
    const name = `${told()}.png`.replace(/[^\w.-]+/g, "-");
    Object.assign(document.createElement("a"), { href: stage.picture(told()), download: name }).click();
  };
  const subject = run.block?.name ?? run.bodies.at(-1)?.name;
  for (const box of document.querySelectorAll("#shows input")) {
    box.checked = stage.labels.on.has(box.name);
    box.onchange = () => {
      if (box.name === "follow") return stage.follow(box.checked ? subject : null);
      if (box.checked) stage.labels.on.add(box.name);
      else stage.labels.on.delete(box.name);
      stage.ask();
    };
    box.parentElement.hidden = !(run.block || ["names", "loads", "follow"].includes(box.name));
  }
  el("save").onclick = save;
  keyboard({ run, player, stage, events, speed, toggle, save, help: el("help"), follow: document.querySelector("#shows [name=follow]") });

  tell();
  paint(dark.matches ? "dark" : "light");
  stage.resize();
  start();
  stage.draw(stage.quality.best);
  root.dataset.ready = "yes";
  window.heavylift = { run, player, stage }; // for the console, and for tests
  return { player, charts, stages, events, stage, tell };
}

function live(address) {
  let parts = null;
  let drawn = 0;
  const grow = () => {
    drawn = performance.now();
    parts.charts.grow();
    parts.stages.grow();
    parts.events.grow();
    parts.tell();
  };
  listen(address, {
    begun(run) {
      parts = open(run);
      el("follow").hidden = false;
      parts.player.follow(true);
    },
    grown(run) {
      if (performance.now() - drawn > GROW_ms) grow();
      const { player } = parts;
      requestAnimationFrame(() => (player.following ? player.follow(true) : player.show(player.now)));
      root.dataset.samples = run.t.length;
    },
    ended() {
      parts.stage.frame();
      grow();
      parts.player.jump(parts.player.now);
      el("follow").hidden = true;
      root.dataset.ended = "yes";
    },
    lost: (away) => (el("lost").hidden = !away),
  });
}

if (given.live) live(given.live);
else {
  const run = new Run(given);
  const parts = open(run);
  run.refine().then((finer) => {
    if (!finer) return;
    parts.charts.grow();
    parts.player.jump(parts.player.now);
    root.dataset.finer = "yes";
  });
}
