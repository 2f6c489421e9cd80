// What stands beside the scene: stages, events, ropes and facts. All text comes in as text, never as markup.
import { lastBefore } from "./data.js";
import { useColour } from "./ropes.js";

const element = (tag, properties = {}, ...children) => {
  const e = Object.assign(document.createElement(tag), properties);
  e.append(...children);
  return e;
};
const cell = (text) => element("td", { textContent: text });

export class StageBar {
  constructor(host, table, run, jump) {
    Object.assign(this, { host, table, run, jump, parts: [] });
    this.grow();
  }

  grow() {
    const { run, parts } = this;
    for (const stage of run.stages.slice(parts.length)) {
      const part = element("button", { type: "button", title: `${stage.name}, ${run.clock(stage.t)}` }, element("span", { textContent: stage.name }));
      part.onclick = () => this.jump(stage.t);
      this.host.append(part);
      parts.push(part);
    }
    const end = (i) => run.stages[i + 1]?.t ?? run.last;
    parts.forEach((part, i) => (part.style.flexGrow = Math.max(0, (end(i) - run.stages[i].t) / (run.last - run.first || 1))));
    this.table.replaceChildren(...run.stages.map((s, i) => element("tr", {}, cell(s.name), cell(run.clock(s.t)), cell(run.clock(Math.max(0, end(i) - s.t))))));
    this.table.closest("section").hidden = !run.stages.length;
  }

  show(now) {
    const at = lastBefore(this.run.stages, now);
    if (at !== this.at) this.parts.forEach((part, i) => part.classList.toggle("on", i === at));
    this.at = at;
    return this.run.stages[at]?.name ?? "";
  }
}

// Orders and inputs are for whoever debugs a model: hidden until they are asked for.
export class EventList {
  constructor(host, all, run, jump) {
    Object.assign(this, { host, all, run, jump, rows: [], at: -1 });
    all.onchange = () => host.classList.toggle("all", all.checked);
    this.grow();
  }

  grow() {
    const { run } = this;
    for (const event of run.events.slice(this.rows.length)) {
      const row = element(
        "li", { tabIndex: 0, className: event.inner ? "inner" : "" },
        element("b", { textContent: run.clock(event.t) }),
        element("i", { textContent: event.source }),
        element("span", { textContent: event.text }),
      );
      row.onclick = () => this.jump(event.t);
      row.onkeydown = (e) => e.key === "Enter" && this.jump(event.t);
      this.host.append(row);
      this.rows.push(row);
    }
  }

  show(now) {
    const at = lastBefore(this.run.events, now);
    if (at === this.at) return;
    this.rows[this.at]?.classList.remove("on");
    const row = this.rows[at];
    row?.classList.add("on");
    if (row?.offsetParent) this.host.scrollTop = row.offsetTop - this.host.clientHeight / 2;
    this.at = at;
  }

  // The time of the next visible event after now, or the one before it.
  next(now, way) {
    const seen = this.run.events.filter((e) => this.all.checked || !e.inner);
    return (way > 0 ? seen.find((e) => e.t > now + 1e-6) : seen.findLast((e) => e.t < now - 1e-6))?.t;
  }
}

export function ropeTable(host, run) {
  host.closest("section").hidden = !run.peaks.length;
  const most = (rope) => (rope.rated ? 1 + rope.tension / rope.rated : 0);
  const peaks = [...run.peaks].sort((a, b) => most(b) - most(a));
  host.replaceChildren(...peaks.map((rope) => {
    const use = rope.rated ? rope.tension / rope.rated : null;
    const share = cell(use === null ? "" : `${(100 * use).toFixed(0)} %`);
    if (use !== null) share.style.borderLeft = `4px solid #${useColour(use).getHexString()}`;
    return element(
      "tr", {},
      cell(rope.name), cell((rope.tension / 1e3).toFixed(1) + " kN"), cell(run.clock(rope.time)),
      cell(rope.rated ? (rope.rated / 1e3).toFixed(0) + " kN" : ""), share,
    );
  }));
}

export function factList(host, run) {
  host.replaceChildren(...run.facts.flatMap(([name, text]) => [element("dt", { textContent: name }), element("dd", { textContent: text })]));
}
