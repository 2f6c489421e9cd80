// The workbench: text, form and faults on the left, the lift in four views, its path at rest and its checks on the right.
import "./workbench.css";
import { api, listen, Refused, type Fault, type Scene } from "./api";
import { CheckTable } from "./checks";
import { button, element } from "./dom";
import { Editor } from "./editor";
import { FaultList } from "./faults";
import { Form } from "./form";
import { Runs } from "./runs";
import { Schema } from "./schema";
import { Tree } from "./tree";
import { Views } from "./views";
import { words } from "./words";

const root = document.documentElement;
let scene: Scene = { scenes: [], bundled: [], file: "", number: 0 };
let busy = false;
let faultsOf = "";
let proposed = 0; // number of the last proposal

const editor = new Editor(() => showForm());
const form = new Form((edits) => editor.edit(edits), (at) => {
  editor.view.dispatch({ selection: { anchor: at }, scrollIntoView: true });
  showForm();
});
const views = new Views(() => {}, (edits) => editor.edit(edits));
const faults = new FaultList((fault: Fault) => editor.go(fault.line, fault.column));
const runs = new Runs(() => editor.save(), () => checks.open("runs"));
const checks: CheckTable = new CheckTable((check) => {
  if (check.t !== undefined && check.t !== null) views.at(check.t, check.stage);
  const [, line, column] = /:(\d+):(\d+)$/.exec(check.where) ?? [];
  if (line) editor.go(Number(line), Number(column));
}, runs.host);
const choice = element("select", { "aria-label": words.scene });
const status = element("span", { id: "status", role: "status", textContent: words.connecting });
const lost = element("span", { id: "lost", role: "alert", hidden: true, textContent: words.lost });
const copy = button(words.copy, () => {
  const name = prompt(words.copyName, scene.own ? `${scene.file.replace(/\.ya?ml$/, "")}-2` : `my-${scene.file.replace(/\.yaml$/, "")}`);
  if (name) void tried(api.copy(name));
}, { hidden: true });

async function tried(asked: Promise<unknown>): Promise<void> {
  try {
    await asked;
  } catch (error) {
    if (!(error instanceof Refused)) throw error;
    status.textContent = error.message;
  }
}

function showForm(): void {
  if (!editor.schema) return;
  const tree = new Tree(editor.view.state);
  form.show(tree, editor.schema, tree.path(editor.view.state.selection.main.head));
}

// What is not of the present text is marked until what is has come.
function mark(): void {
  const bad = faults.faults.length > 0 && faultsOf === scene.version;
  const old = (version: string) => version !== "" && version !== scene.version;
  views.mark(old(views.version) ? (bad ? words.lastGood : words.stale) : "");
  checks.stale(old(checks.version) ? (bad ? words.lastGood : words.stale) : "");
  status.textContent = busy ? (old(views.version) ? words.reading : words.checking) : bad ? words.faults(faults.faults.length) : scene.file ? words.current : words.none;
  root.dataset.busy = String(busy);
}

function listScenes(): void {
  const of = (names: string[]) => names.map((name) => element("option", { value: name, textContent: name, selected: name === scene.file }));
  const own = scene.scenes.includes(scene.file);
  const stem = scene.file.replace(/\.yaml$/, "");
  choice.replaceChildren(element("option", { value: "", textContent: words.none, selected: !scene.file }), ...of(scene.scenes),
    element("optgroup", { label: words.bundled }, ...scene.bundled.map((name) => element("option", { value: name, textContent: name, selected: !own && name === stem }))));
}

choice.onchange = () => {
  if (choice.value) void editor.save().then(() => tried(api.open(choice.value)));
};

function paint(theme: string): void {
  root.dataset.theme = theme;
  views.paint(theme);
}

const dark = matchMedia("(prefers-color-scheme: dark)");
dark.onchange = () => paint(dark.matches ? "dark" : "light");
const welcome = element("p", { id: "welcome", textContent: words.welcome });
const header = element("header", {}, element("h1", { textContent: words.title }), choice, copy, status, lost, element("span", { className: "grow" }), runs.begin, ...runs.others,
  button(words.text, () => document.body.classList.toggle("without-text"), { id: "toggle-text" }),
  button(words.theme, () => paint(root.dataset.theme === "dark" ? "light" : "dark")));
document.body.prepend(header, element("main", {}, element("div", { id: "left" }, editor.host, faults.host, form.host), element("div", { id: "right" }, views.host, checks.host, welcome)));
paint(dark.matches ? "dark" : "light");

listen({
  scene(data) {
    const other = data.file !== scene.file;
    scene = data;
    if (other) {
      views.clear();
      checks.take(null);
      document.title = `${data.file} · ${words.title}`;
    }
    copy.hidden = !data.file;
    root.classList.toggle("empty", !data.file);
    copy.textContent = data.own ? words.duplicate : words.copy;
    listScenes();
    if (data.file) editor.take(data);
    mark();
  },
  busy(data) {
    busy = data.busy;
    if (!busy) views.settle();
    mark();
  },
  faults(data) {
    faultsOf = data.version;
    faults.take(data.faults, (scene.text ?? "").split("\n"), scene.file);
    editor.mark(data.faults);
    mark();
  },
  picture(data) {
    views.take(data);
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
    if (data.file === scene.file.replace(/\.ya?ml$/, "-planned.yaml").split("/").at(-1)) editor.propose(data.text);
  },
}, (away) => (lost.hidden = !away));

void runs.refresh();
void api.schema().then((schema) => {
  editor.schema = new Schema(schema);
  root.dataset.schema = "yes";
  showForm();
});
root.dataset.ready = "yes";
Object.assign(window, { workbench: { editor, views } }); // for the console, and for tests
