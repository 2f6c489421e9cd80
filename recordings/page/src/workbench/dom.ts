// Elements with text, never markup.
type Properties = Record<string, unknown>;

export function element<K extends keyof HTMLElementTagNameMap>(tag: K, properties: Properties = {}, ...children: (Node | string)[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made) (made as unknown as Properties)[name] = value;
    else made.setAttribute(name, String(value));
  }
  made.append(...children);
  return made;
}

export function button(text: string, press: () => void, properties: Properties = {}): HTMLButtonElement {
  return element("button", { type: "button", textContent: text, onclick: press, ...properties });
}

// Markup that the server has made of tables; scripts in it are not run, the policy of the page forbids them.
export function markup(html: string): DocumentFragment {
  return document.createRange().createContextualFragment(html);
}
