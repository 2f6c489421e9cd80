// What stands beside the scene: stages, events, ropes and facts. All text comes in as text, never as markup.
import { clock } from "./data.js";
import { useColour } from "./stage.js";

const element = (tag, properties = {}, ...children) => {
  const e = Object.assign(document.createElement(tag), properties);
  e.append(...children);
  return e;
};

export function stageBar(host, run, jump) {
  const span = run.last - run.first || 1;
  run.stages.forEach((stage, i) => {
    const end = run.stages[i + 1]?.t ?? run.last;
    const part = element("button", { type: "button", title: `${stage.name}, ${clock(stage.t)}`, textContent: stage.name });
    part.style.flexGrow = Math.max(0, (end - stage.t) / span);
    part.onclick = () => jump(stage.t);
    host.append(part);
  });
  return (now) => {
    const at = run.stages.findLastIndex((s) => s.t <= now);
    [...host.children].forEach((part, i) => part.classList.toggle("on", i === at));
    return run.stages[at]?.name ?? "";
  };
}

// Orders and inputs are for whoever debugs a model: hidden until they are asked for.
export function eventList(host, all, run, jump) {
  all.onchange = () => host.classList.toggle("all", all.checked);
  const rows = run.events.map((event) => {
    const row = element(
      "li", { tabIndex: 0, className: event.inner ? "inner" : "" },
      element("b", { textContent: clock(event.t) }),
      element("i", { textContent: event.source }),
      element("span", { textContent: event.text }),
    );
    row.onclick = () => jump(event.t);
    host.append(row);
    return row;
  });
  let last = -1;
  return (now) => {
    const at = run.events.findLastIndex((e) => e.t <= now);
    if (at === last) return;
    rows[last]?.classList.remove("on");
    rows[at]?.classList.add("on");
    if (rows[at]) host.scrollTop = rows[at].offsetTop - host.offsetTop - host.clientHeight / 2;
    last = at;
  };
}

export function ropeTable(host, run) {
  for (const rope of run.peaks) {
    const use = rope.rated ? rope.tension / rope.rated : null;
    const cell = (text) => element("td", { textContent: text });
    const share = cell(use === null ? "" : `${(100 * use).toFixed(0)} %`);
    if (use !== null) share.style.borderLeft = `4px solid #${useColour(use).getHexString()}`;
    host.append(element(
      "tr", {},
      cell(rope.name), cell((rope.tension / 1e3).toFixed(1) + " kN"), cell(clock(rope.time)),
      cell(rope.rated ? (rope.rated / 1e3).toFixed(0) + " kN" : ""), share,
    ));
  }
}

export function factList(host, run) {
  for (const [name, text] of run.facts) host.append(element("dt", { textContent: name }), element("dd", { textContent: text }));
}
