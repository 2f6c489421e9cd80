// Elements with text, never markup.
type Properties = Record<string, unknown>;
type Child = Node | string | false | null | undefined;

export function element<K extends keyof HTMLElementTagNameMap>(tag: K, properties: Properties = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made && name !== "list") (made as unknown as Properties)[name] = value;
    else made.setAttribute(name, String(value));
  }
  made.append(...children.filter((x): x is Node | string => !!x));
  return made;
}

export function button(text: string, press: () => void, properties: Properties = {}): HTMLButtonElement {
  return element("button", { type: "button", textContent: text, onclick: press, ...properties });
}

export const option = (value: string, text = value, properties: Properties = {}) => element("option", { value, textContent: text, ...properties });

// A choice with a label; `change` gets what is chosen.
export function choice(label: string, options: HTMLElement[], change: (value: string) => void, properties: Properties = {}): HTMLSelectElement {
  const made = element("select", { "aria-label": label, title: label, ...properties }, ...options);
  made.onchange = () => change(made.value);
  return made;
}

// Markup that the server has made of tables; scripts in it are not run, the policy of the page forbids them.
export function markup(html: string): DocumentFragment {
  return document.createRange().createContextualFragment(html);
}

let asked = 0;

// A small form over the page; `done` gets its fields, and keeps it open with a sentence that it returns.
export function ask(title: string, go: string, cancel: string, fields: HTMLElement[], done: () => Promise<string> | string): HTMLDialogElement {
  const error = element("p", { className: "error", role: "alert" });
  const id = `ask-${asked++}`;
  const form = element("form", {}, element("h2", { textContent: title, id }), ...fields, error,
    element("div", { className: "buttons" }, button(cancel, () => made.close()), element("button", { className: "primary", textContent: go })));
  const made = element("dialog", { "aria-labelledby": id }, form);
  form.onsubmit = (e) => {
    e.preventDefault();
    void Promise.resolve(done()).then((refused) => (refused ? (error.textContent = refused) : made.close()));
  };
  made.onclose = () => made.remove();
  document.body.append(made);
  made.showModal();
  return made;
}

export const labelled = (text: string, field: HTMLElement) => element("label", { className: "row" }, element("span", { textContent: text }), field);
