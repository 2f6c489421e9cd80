// The workbench: outline and form, the text, the lift in four views with its stages, checks and runs.
import "./workbench.css";
import { api, listen, type Check, type Fault, type Path, type Scene } from "./api";
import { CheckTable } from "./checks";
import { button, choice, element, option } from "./dom";
import { Editor } from "./editor";
import { FaultList } from "./faults";
import { Form } from "./form";
import { pace, seconds, stretched } from "./orders";
import { Outline } from "./outline";
import { Runs } from "./runs";
import { Schema } from "./schema";
import { Start } from "./start";
import { Studies } from "./studies";
import { type Edit, type Template, templates } from "./templates";
import { Tree } from "./tree";
import { Views } from "./views";
import { words } from "./words";

const NARROW_px = 1280; // below, the text is hidden until it is asked for
const root = document.documentElement;
let scene: Scene = { scenes: [], bundled: [], file: "", number: 0 };
let busy = false;
let faultsOf = "";
let proposed = 0; // number of the last proposal
let selected: Path = [];
let known: Template[] = [];
let tree: Tree | null = null;

const editor = new Editor(() => {
  tree = new Tree(editor.view.state);
  selected = tree.path(editor.view.state.selection.main.head);
  showForm();
});
const edit = async (edits: Edit[] | (() => Edit[])) => {
  const refused = await editor.edit(typeof edits === "function" ? edits : () => edits);
  if (refused) status.textContent = refused;
  return refused;
};
const form = new Form(edit, go, () => views.hooks);
const outline = new Outline(go, (template) => void edit(() => template.edit(tree!, views.hooks)));
const views: Views = new Views({
  edit,
  picked: go,
  written: (path) => {
    const node = tree?.at(path) ?? null;
    return node && tree!.collection(node) ? tree!.entries(node).map((x) => tree!.plain(x.value)) : node ? [tree!.plain(node)] : [];
  },
  stretch: (action, factor) => void edit(() => stretched(orders(action), factor).map(([key, value]) => ({ path: ["actions", action, key], value }))),
  actions: () => (tree?.entries(tree.at(["actions"])) ?? []).map((x, i) => {
    const written = orders(i);
    const of = (key: string) => written.find(([name]) => name === key)?.[1] ?? "";
    return { name: of("stage") || tree!.text(x.value).split("\n")[0], pace: pace(written), wait: seconds(of("wait")) };
  }),
  reached: (t) => runs.reached(t),
  play: () => void (views.motion.run || runs.play(`${stem()}.mcap`)),
  left: () => {
    runs.left();
    checks.judge(null, "");
  },
});
const faults = new FaultList((fault: Fault) => {
  withText(true);
  editor.go(fault.line, fault.column);
});
const runs: Runs = new Runs({
  saved: () => editor.save(),
  shown: (tab) => checks.open(tab),
  play(name, played) {
    views.open(name, played);
    checks.judge(played.checks, name);
  },
  live: (file) => views.motion.live(file),
  end: () => views.end,
});
const studies = new Studies(runs);
runs.onlisted.push(() => views.recorded(runs.found.some((x) => x.name === `${stem()}.mcap`) ? `${stem()}.mcap` : ""));
const checks: CheckTable = new CheckTable((check: Check) => {
  const near = checks.near.find((x) => x.names.every((name) => check.subject.includes(name)));
  views.point(check, near?.ends);
  const [, line, column] = /:(\d+):(\d+)$/.exec(check.where) ?? [];
  if (line) editor.go(Number(line), Number(column), false);
}, () => void edit([{ path: ["assumed"], value: "accept" }]), { runs: runs.host, studies: studies.host });
const start = new Start(runs, () => editor.save());
const status = element("span", { id: "status", role: "status", textContent: words.connecting });
const lost = element("span", { id: "lost", role: "alert", hidden: true, textContent: words.lost });
const files = choice(words.scene, [], (name) => {
  if (name === words.home) root.classList.add("home");
  else void start.open(name);
});
const copy = button(words.copy, () => start.copy(scene.own ? words.duplicateTitle : words.copyTitle, scene.own ? `${stem()}-2` : `my-${stem()}`), { id: "copy" });
const report = button(words.documents, () => {
  void runs.report(stem());
}, { title: words.documentsHelp });
const text = button(words.text, () => withText(document.body.classList.contains("without-text")), { id: "toggle-text", title: words.textHelp });

function stem(): string {
  return scene.file.replace(/\.ya?ml$/, "").split("/").at(-1)!;
}

function orders(action: number): [string, string][] {
  return (tree?.entries(tree.at(["actions", action])) ?? []).map((x) => [String(x.key), tree!.plain(x.value)]);
}

// Lead to a thing in outline, form and text, whether it is written yet or not.
function go(path: Path): void {
  if (!tree) return;
  const at = tree.at(path)?.from;
  if (at !== undefined) editor.select(at);
  selected = path;
  showForm();
  if (path[0] === "actions" && path.length > 1) views.action(Number(path[1]));
}

function showForm(): void {
  if (!editor.schema || !tree) return;
  form.show(tree, editor.schema, selected);
  outline.show(tree, selected, known, faultsOf === scene.version ? faults.faults.map((x) => x.path) : []);
}

function withText(on: boolean): void {
  document.body.classList.toggle("without-text", !on);
  text.setAttribute("aria-pressed", String(on));
}

// What is not of the present text is marked until what is has come.
function mark(): void {
  const bad = faults.faults.length > 0 && faultsOf === scene.version;
  const old = (version: string) => version !== "" && version !== scene.version;
  runs.block(bad);
  views.mark(old(views.version) ? (bad ? words.lastGood : words.stale) : "");
  checks.stale(old(checks.version) ? (bad ? words.lastGood : words.stale) : "");
  status.textContent = busy ? (old(views.version) ? words.reading : words.checking) : bad ? words.faults(faults.faults.length) : scene.file ? words.current : words.none;
  root.dataset.busy = String(busy);
}

function listScenes(): void {
  const own = scene.scenes.includes(scene.file);
  const of = (names: string[], of_own: boolean) => names.map((name) => option(name, name, { selected: of_own ? name === scene.file : !own && name === stem() }));
  files.replaceChildren(option(words.home, words.home, { selected: !scene.file }), element("optgroup", { label: words.scenesHere }, ...of(scene.scenes, true)),
    element("optgroup", { label: words.bundled }, ...of(scene.bundled, false)));
}

function paint(theme: string): void {
  root.dataset.theme = theme;
  views.paint(theme);
}

const dark = matchMedia("(prefers-color-scheme: dark)");
dark.onchange = () => paint(dark.matches ? "dark" : "light");
const header = element("header", {}, element("h1", { textContent: words.title }), files, button(words.fresh, () => start.begin(), { title: words.freshTitle }), copy, editor.tools, status, lost, element("span", { className: "grow" }),
  runs.control, runs.begin, runs.plan, report, text, button("◐", () => paint(root.dataset.theme === "dark" ? "light" : "dark"), { title: words.theme, "aria-label": words.theme }));
document.body.prepend(header, element("main", {},
  element("div", { id: "left" }, outline.host, form.host),
  element("div", { id: "middle" }, editor.host),
  element("div", { id: "right" }, element("div", { id: "notices" }, editor.conflict, editor.proposal.host, faults.host), views.host, checks.host), start.host));
paint(dark.matches ? "dark" : "light");
withText(innerWidth >= NARROW_px);

listen({
  scene(data) {
    const other = data.file !== scene.file;
    scene = data;
    if (other) {
      views.clear();
      checks.take(null);
      selected = [];
      root.classList.remove("home");
      document.title = `${data.file || words.home} · ${words.title}`;
    }
    copy.hidden = !data.file;
    root.classList.toggle("empty", !data.file);
    copy.textContent = data.own ? words.duplicate : words.copy;
    listScenes();
    if (data.file) editor.take(data);
    void runs.refresh().then(() => start.show(data));
    mark();
  },
  busy(data) {
    busy = data.busy;
    if (!busy) views.settle();
    if (!busy && tree) studies.take(tree);
    mark();
  },
  faults(data) {
    faultsOf = data.version;
    faults.take(data.faults, editor.lines, scene.file);
    editor.mark(data.faults);
    showForm();
    mark();
  },
  picture(data) {
    views.take(data);
    showForm();
    mark();
  },
  checks(data) {
    checks.take(data);
    mark();
  },
  run: (data) => runs.take(data),
  proposal(data) {
    if (data.number <= proposed) return;
    proposed = data.number;
    if (data.file === `${stem()}-planned.yaml`) editor.propose(data.text);
  },
}, (away) => (lost.hidden = !away));

void runs.refresh().then(() => start.show(scene));
void api.schema().then((schema) => {
  editor.schema = new Schema(schema);
  known = templates(editor.schema);
  root.dataset.schema = "yes";
  showForm();
});
root.dataset.ready = "yes";
Object.assign(window, { workbench: { editor, views } }); // for the console, and for tests
