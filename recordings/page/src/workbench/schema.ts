// The JSON Schema of scenes: what may stand at a path, and what it means.
import type { Path } from "./api";

export interface Part {
  $ref?: string; type?: string | string[]; properties?: Record<string, Part>; additionalProperties?: Part | boolean; items?: Part | boolean;
  prefixItems?: Part[]; anyOf?: Part[]; oneOf?: Part[]; allOf?: Part[]; if?: Part; then?: Part; enum?: unknown[]; const?: unknown;
  description?: string; default?: unknown; dimension?: string; pattern?: string; required?: string[]; $defs?: Record<string, Part>;
}
export interface Key { name: string; part: Part; required: boolean }

export class Schema {
  constructor(private readonly root: Part) {}

  // All forms that a part may have; conditions on `type` decide by what is written there.
  private forms(part: Part | boolean | undefined, type: string): Part[] {
    if (!part || typeof part === "boolean") return [];
    if (part.$ref) return this.forms({ ...this.root.$defs![part.$ref.split("/").at(-1)!], ...(part.description ? { description: part.description } : {}) }, type);
    const several = [...(part.anyOf ?? []), ...(part.oneOf ?? [])].flatMap((x) => this.forms(x, type));
    const more = (part.allOf ?? []).flatMap((x) => (x.if ? (x.if.properties?.type?.const === type ? this.forms(x.then, type) : []) : this.forms(x, type)));
    return [part, ...several, ...more];
  }

  // What may stand at a path; `typeAt` tells the type that is written in the mapping at a path.
  at(path: Path, typeAt: (path: Path) => string): Part[] {
    let found = this.forms(this.root, "");
    path.forEach((key, i) => {
      const type = typeAt(path.slice(0, i + 1));
      const next = found.flatMap((part) => {
        if (typeof key === "number") return this.forms(part.prefixItems?.[key] ?? part.items, type);
        return this.forms(part.properties?.[key] ?? part.additionalProperties, type);
      });
      found = next;
    });
    return found;
  }

  // The types of cranes, each with its description.
  types(): [string, string][] {
    return (this.root.$defs?.CraneKeys?.allOf ?? []).map((x): [string, string] => [String(x.if?.properties?.type?.const ?? ""), x.then?.description ?? ""]).filter(([name]) => name);
  }

  keys(parts: Part[]): Key[] {
    const found = new Map<string, Key>();
    for (const part of parts) {
      for (const [name, of] of Object.entries(part.properties ?? {})) {
        const before = found.get(name);
        found.set(name, { name, part: { ...before?.part, ...of }, required: !!part.required?.includes(name) || !!before?.required });
      }
    }
    return [...found.values()];
  }

  // Values that can be picked.
  values(part: Part): string[] {
    const forms = this.forms(part, "");
    const picked = forms.flatMap((x) => [...(x.enum ?? []), ...(x.const !== undefined ? [x.const] : []), ...(x.type === "boolean" ? [true, false] : [])]);
    return [...new Set(picked.map(String))];
  }

  // A sentence about a part: what it is, in which dimension, what it is without being written.
  about(part: Part): string {
    const forms = this.forms(part, "");
    const dimension = forms.find((x) => x.dimension)?.dimension;
    const text = forms.find((x) => x.description)?.description ?? "";
    const value = this.standard(part);
    return [text, dimension && !text.includes(dimension) ? dimension : "", value && `default ${value}`].filter(Boolean).join("; ");
  }

  // What a part is without being written; "" where that is no single value.
  standard(part: Part): string {
    const value = this.forms(part, "").find((x) => x.default !== undefined && x.default !== null)?.default;
    return ["string", "number", "boolean"].includes(typeof value) ? String(value) : "";
  }
}
