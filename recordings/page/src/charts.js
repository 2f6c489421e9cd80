// Signals over time: one chart per group that is switched on, all with the common cursor of the page.
import uPlot from "uplot";
import { locate } from "./data.js";

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7a6fd0", "#6b7682"];
const SCALE = { N: [1e-3, "kN"], J: [1e-6, "MJ"] };
const LEGEND_ms = 100;
const HEIGHT = 240; // [pixel]
const MANY = 8; // curves of a group that are shown at first

// The group of the run that goes with a measured one; "" if there is none.
const modelled = (group) => (group.startsWith("measured/") ? group.slice(9) : "");

export class Charts {
  constructor(host, picker, run, jump) {
    Object.assign(this, { host, run, jump, plots: [], theme: "light" });
    this.shown = new Map(); // which curves of a group are shown, as the user has chosen
    const groups = [...new Set(run.signals.map((s) => s.group))];
    this.groups = groups.filter((g) => !groups.includes(modelled(g)));
    const wanted = this.groups.filter((g) => g === "rope/tension");
    this.on = new Set(wanted.length ? wanted : this.groups.slice(0, 1));
    for (const group of this.groups) {
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = this.on.has(group);
      box.onchange = () => {
        if (box.checked) this.on.add(group);
        else this.on.delete(group);
        this.draw();
      };
      label.append(box, " " + group);
      picker.append(label);
    }
  }

  // The run has grown: new numbers into the same charts.
  grow() {
    for (const plot of this.plots) plot.setData(this.data(plot.signals, plot.factor), true);
    this.cursor(this.now ?? this.run.first);
  }

  data(signals, factor) {
    const real = (s) => Array.from(s.y, (v) => (Number.isNaN(v) ? null : v * factor)); // before and after the log
    return [this.run.t, ...signals.map((s) => (/^(measured|error)\//.test(s.group) ? real(s) : factor === 1 ? s.y : s.y.map((v) => v * factor)))];
  }

  draw() {
    for (const plot of this.plots) plot.destroy();
    this.host.replaceChildren();
    this.plots = this.groups.filter((g) => this.on.has(g)).map((group) => this.chart(group));
    clearTimeout(this.told);
    this.told = undefined;
    this.cursor(this.now ?? this.run.first);
  }

  chart(group) {
    const own = this.run.signals.filter((s) => s.group === group);
    const signals = [...own, ...this.run.signals.filter((s) => modelled(s.group) === group)];
    const label = (s) => (s.group === group ? s.name : `${s.name} measured`);
    const colour = (s) => COLOURS[Math.max(0, own.findIndex((o) => o.name === s.name)) % COLOURS.length];
    const [factor, unit] = SCALE[signals[0].unit] ?? [1, signals[0].unit];
    const ink = this.theme === "dark" ? "#c7d1db" : "#33404d";
    const rule = this.theme === "dark" ? "#2b3640" : "#e1e6eb";
    const axis = { stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule } };
    const shown = this.shown.get(group) ?? new Map(signals.map((s) => [label(s), own.findIndex((o) => o.name === s.name) < MANY]));
    this.shown.set(group, shown);
    const shaded = (plot) => this.stages(plot);
    const marked = (plot) => this.mark(plot);
    const told = (plot) => plot.setLegend({ idx: this.at }, false);
    const options = {
      title: `${group} [${unit}]`, width: this.host.clientWidth - 4, height: HEIGHT,
      scales: { x: { time: false } }, legend: { live: true },
      cursor: { sync: { key: "run" }, drag: { x: true, y: false } },
      hooks: {
        ready: [told], drawClear: [shaded], draw: [marked],
        setSeries: [(plot, i) => i && shown.set(label(signals[i - 1]), plot.series[i].show)],
      },
      series: [
        { label: "t [s]" },
        ...signals.map((s) => ({ label: label(s), stroke: colour(s), dash: s.group === group ? [] : [5, 4], width: 1.4, show: shown.get(label(s)) })),
      ],
      axes: [axis, { ...axis, size: 64 }],
    };
    const host = document.createElement("div");
    this.host.append(host);
    const plot = Object.assign(new uPlot(options, this.data(signals, factor), host), { signals, factor });
    plot.mark = document.createElement("div");
    plot.mark.className = "now";
    plot.over.append(plot.mark);
    plot.over.addEventListener("click", (e) => {
      if (plot.select.width < 2) this.jump(plot.posToVal(e.offsetX, "x"));
    });
    return plot;
  }

  // Every other stage is shaded.
  stages(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.fillStyle = this.theme === "dark" ? "#ffffff0a" : "#0000000a";
    this.run.stages.forEach((stage, i) => {
      if (i % 2) return;
      const end = this.run.stages[i + 1]?.t ?? this.run.last;
      const x0 = Math.max(bbox.left, plot.valToPos(stage.t, "x", true));
      const x1 = Math.min(bbox.left + bbox.width, plot.valToPos(end, "x", true));
      if (x1 > x0) ctx.fillRect(x0, bbox.top, x1 - x0, bbox.height);
    });
    ctx.restore();
  }

  cursor(now) {
    this.now = now;
    const { i } = locate(this.run.t, now);
    for (const plot of this.plots) this.mark(plot);
    this.tell(i);
  }

  // The line of the common time; a chart has its size and its scale only when it is drawn.
  mark(plot) {
    const x = plot.valToPos(this.now, "x");
    plot.mark.style.transform = `translateX(${x}px)`;
    plot.mark.hidden = x < 0 || x > plot.bbox.width / devicePixelRatio;
  }

  // The numbers at the cursor are for a reader: ten times a second is plenty.
  tell(i) {
    this.at = i;
    if (this.told) return;
    for (const plot of this.plots) plot.setLegend({ idx: i }, false);
    this.told = setTimeout(() => {
      this.told = undefined;
      if (this.at !== i) this.tell(this.at);
    }, LEGEND_ms);
  }

  paint(theme) {
    this.theme = theme;
    this.draw();
  }

  resize() {
    for (const plot of this.plots) plot.setSize({ width: this.host.clientWidth - 4, height: HEIGHT });
    this.cursor(this.now ?? this.run.first);
  }
}
