// Signals over time: one chart per group that is switched on, all with the common cursor of the page.
import uPlot from "uplot";
import { locate, timeAxis } from "./data.js";

const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7a6fd0", "#6b7682"];
const SCALE = { N: [1e-3, "kN"], J: [1e-6, "MJ"] };
const LEGEND_ms = 100;
const HEIGHT = 240; // [pixel]
const MANY = 8; // curves of a group that are shown at first
const NEAR = 2.5; // times what is drawn: a limit that is farther away is not

// The group of the run that goes with a measured one, or one of another run; "" if there is none.
const OTHER = /^(measured|beside)\//;
const modelled = (group) => (OTHER.test(group) ? group.replace(OTHER, "") : "");

export class Charts {
  constructor(host, picker, run, jump) {
    Object.assign(this, { host, run, jump, plots: [], theme: "light" });
    this.shown = new Map(); // which curves of a group are shown, as the user has chosen
    for (const signal of run.signals) signal.chart = signal.group;
    const units = Map.groupBy(run.signals, (s) => s.group); // a chart has one unit: places and angles of joints are apart
    for (const [group, of] of units) if (new Set(of.map((s) => s.unit)).size > 1) for (const s of of) s.chart = `${group} [${s.unit}]`;
    const groups = [...new Set(run.signals.map((s) => s.chart))];
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
    return [this.run.t, ...signals.map((s) => (/^(measured|error|beside)\//.test(s.group) ? real(s) : factor === 1 ? s.y : s.y.map((v) => v * factor)))];
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
    const { run } = this;
    const ropes = group === "rope/tension";
    const own = run.signals.filter((s) => s.chart === group);
    if (ropes) {
      const use = new Map(own.map((s) => [s, run.use(s.name)])); // those that are used most first
      own.sort((a, b) => use.get(b) - use.get(a));
    }
    const signals = [...own, ...run.signals.filter((s) => modelled(s.chart) === group)];
    const label = (s) => (s.chart === group ? s.name : `${s.name} ${s.group.startsWith("beside/") ? run.beside : "measured"}`);
    const colour = (s) => COLOURS[Math.max(0, own.findIndex((o) => o.name === s.name)) % COLOURS.length];
    const [factor, unit] = SCALE[signals[0].unit] ?? [1, signals[0].unit];
    const ink = this.theme === "dark" ? "#c7d1db" : "#33404d";
    const rule = this.theme === "dark" ? "#2b3640" : "#e1e6eb";
    const limits = () => (ropes ? [...new Set(own.filter((s) => shown.get(s.name) && run.rated[s.name]).map((s) => run.rated[s.name] * factor))] : []);
    const axis = { stroke: ink, grid: { stroke: rule, width: 1 }, ticks: { stroke: rule } };
    const shown = this.shown.get(group) ?? new Map(signals.map((s) => [label(s), own.findIndex((o) => o.name === s.name) < MANY]));
    this.shown.set(group, shown);
    const shaded = (plot) => this.stages(plot);
    const marked = (plot) => this.mark(plot);
    const told = (plot) => plot.setLegend({ idx: this.at }, false);
    const range = (plot, low, high) => {
      if (low === null) return [null, null];
      const near = limits().filter((y) => y < NEAR * high);
      return uPlot.rangeNum(low, Math.max(high, ...near), 0.1, true);
    };
    const options = {
      title: `${group.split(" [")[0]} [${unit}]`, width: this.host.clientWidth - 4, height: HEIGHT,
      scales: { x: { time: false }, y: { range } }, legend: { live: true },
      cursor: { sync: { key: "run" }, drag: { x: true, y: false } },
      hooks: {
        ready: [told], drawClear: [shaded], draw: [marked, (plot) => this.limits(plot, limits(), unit)],
        setSeries: [(plot, i) => i && shown.set(label(signals[i - 1]), plot.series[i].show)],
      },
      series: [
        { label: "time", value: (plot, t) => (t === null ? "" : run.clock(t)) },
        ...signals.map((s) => ({ label: label(s), stroke: colour(s), dash: s.chart === group ? [] : [5, 4], width: 1.4, show: shown.get(label(s)) })),
      ],
      axes: [
        { ...axis, ...timeAxis },
        { ...axis, size: 64 },
      ],
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

  // Rated values as dashed lines.
  limits(plot, values, unit) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = this.theme === "dark" ? "#ff6b5e" : "#a3182b";
    ctx.setLineDash([8 * devicePixelRatio, 5 * devicePixelRatio]);
    ctx.font = `${11 * devicePixelRatio}px system-ui, sans-serif`;
    ctx.textAlign = "right";
    ctx.textBaseline = "bottom";
    const label = (low, high, y) => ctx.fillText(
      `rated ${low}${low === high ? "" : ` to ${high}`} ${unit}`, bbox.left + bbox.width - 4, y - 2 * devicePixelRatio);
    let near = null; // the label that waits for others too close to stand beside it
    for (const value of [...values].sort((a, b) => a - b)) {
      const y = plot.valToPos(value, "y", true), text = value.toFixed(0);
      if (y < bbox.top || y > bbox.top + bbox.height) continue;
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      if (near && near.y - y > 13 * devicePixelRatio) label(near.low, near.high, near.y);
      near = near && near.y - y <= 13 * devicePixelRatio ? { ...near, high: text, y } : { low: text, high: text, y };
    }
    if (near) label(near.low, near.high, near.y);
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
