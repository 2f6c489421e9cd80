// What the server says and is asked.
import { words } from "./words";

export type Path = (string | number)[];
export interface Scene { scenes: string[]; bundled: string[]; file: string; own?: boolean; text?: string; version?: string; number: number }
export interface Saved { text: string; version: string; number: number }
export interface Fault { file: string; line: number; column: number; path: string; sentence: string; hint: string }
export interface State { t: number; action: number; stage: string; event: string; last: boolean }
export interface Drawing { title: string; svg: string }
export interface Handle { path: Path; bodies: string[]; at: number[]; free: string; listed: boolean; point?: string; body?: string; p?: number[] }
export interface Hook { name: string; body: string; p: [number, number, number] }
export interface Picture { version: string; number: number; what: "start" | "path"; states: State[]; drawings: Drawing[]; title: string; block: object | null; moving: Handle[]; hooks: Hook[] }
export interface Check {
  state: string; word: string; load: boolean; quantity: string; subject: string; shown: string; allowed: string; use?: number; t?: number;
  stage: string; basis: string; sentence: string; where: string; value?: number; why: string;
}
export interface Near { names: string[]; t: number; ends: number[][] }
export interface Checks { version?: string; state: string; line: string; checks: Check[]; notes: string[]; tables: string[]; ends: string; near?: Near[] }
export interface RunMessage { do: string; running: boolean; lines: string[]; file: string; live: boolean; code?: number }
export interface Proposal { number: number; file: string; text: string }
export interface Recorded { name: string; state: string; line: string; older: boolean }
export interface Folder { recordings: Recorded[]; studies: string[]; bundled: Record<string, string> }
export interface Played { run: object; checks: Checks | null; differences: string[] }
export interface Kept { made: string[]; refused: string[] }
export interface Messages {
  scene: Scene;
  busy: { version: string; busy: boolean };
  faults: { version: string; faults: Fault[] };
  picture: Picture;
  checks: Checks;
  run: RunMessage;
  proposal: Proposal;
}

export function listen(heard: { [K in keyof Messages]: (data: Messages[K]) => void }, lost: (away: boolean) => void): void {
  const source = new EventSource("events");
  for (const kind of Object.keys(heard) as (keyof Messages)[]) {
    source.addEventListener(kind, (e) => (heard[kind] as (data: unknown) => void)(JSON.parse((e as MessageEvent).data)));
  }
  source.onopen = () => lost(false);
  source.onerror = () => lost(true);
}

export class Refused extends Error {}

async function answered<T>(asked: Promise<Response>): Promise<T> {
  const answer = await asked.catch(() => {
    throw new Refused(words.lost);
  });
  const data = await answer.json();
  if (!answer.ok) throw new Refused(data.error);
  return data;
}

const get = <T>(name: string) => answered<T>(fetch(name));
const post = async <T = string>(name: string, body: object): Promise<T> =>
  (await answered<{ answer: T }>(fetch(name, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) }))).answer;

export const api = {
  save: (text: string, version: string) => post<Saved>("save", { text, version }),
  edit: (edits: { path: Path; value: string | number | null }[], version: string) => post<Saved>("edit", { edits, version }),
  open: (name: string) => post("open", { name }),
  copy: (name: string) => post("copy", { name }),
  begin: (name: string, like: string) => post("new", { name, like }),
  run: (act: string, text = "") => post("run", { do: act, text }),
  keep: (name: string) => post<Kept>("keep", { name }),
  folder: () => get<Folder>("folder"),
  played: (name: string, beside = "") => get<Played>(`recording/${encodeURIComponent(name)}${beside && `?beside=${encodeURIComponent(beside)}`}`),
  schema: async () => (await fetch("schema")).json(),
  async drawings(number: number, k: number): Promise<Drawing[] | null> {
    const answer = await fetch(`drawings/${number}/${k}`);
    return answer.ok ? answer.json() : null;
  },
};

// A sentence where something is refused.
export async function tried(asked: Promise<unknown>): Promise<string> {
  try {
    await asked;
    return "";
  } catch (error) {
    if (error instanceof Refused) return error.message;
    throw error;
  }
}
