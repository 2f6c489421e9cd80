// Orders of a stage as parts: verb, speed, ramp, and where the move ends; written back as the phrase that they were read from.
export interface Order { verb: string; speed: string; ramp: string; goal: string; value: string; together: boolean }

const NUMBER = String.raw`[-+]?[\d.]+(?:e[-+]?\d+)?`;
const MOVE = new RegExp(String.raw`^(\w+)\s+(${NUMBER}\s*[^\s\d]\S*)(?:\s+ramp\s+(one swing|${NUMBER}\s*\S+(?:\s+in two pulses)?))?\s+(by|to|until)\s+(.+?)(\s*,?\s+together)?$`);
const QUANTITY = new RegExp(`^(${NUMBER})\\s*(.*)$`);

export const MOVES = ["hoist", "lower", "travel", "traverse", "slew", "luff", "drive", "turn"];
export const GOALS = ["by", "to", "until"];
export const OWN = ["stage", "when", "timeout", "may touch"]; // keys of a stage that are no targets

export function parsed(text: string): Order | null {
  const found = MOVE.exec(text.trim());
  if (!found) return null;
  const [, verb, speed, ramp = "", goal, value, together] = found;
  return { verb, speed, ramp, goal, value, together: !!together };
}

export function composed({ verb, speed, ramp, goal, value, together }: Order): string {
  return [verb, speed, ramp && `ramp ${ramp}`, goal, value].filter(Boolean).join(" ") + (together ? ", together" : "");
}

// A quantity times a factor, to three digits; "" if it is none.
export function scaled(text: string, factor: number): string {
  const found = QUANTITY.exec(text.trim());
  return found ? `${Number((Number(found[1]) * factor).toPrecision(3))} ${found[2]}`.trim() : "";
}

// What of a stage makes it so many times as long: its wait, or the speeds of its moves; by key the new phrase.
export function stretched(orders: [string, string][], factor: number): [string, string][] {
  return orders.flatMap(([key, text]): [string, string][] => {
    if (key === "wait") return [[key, scaled(text, factor)]];
    const order = OWN.includes(key) ? null : parsed(text);
    return order && scaled(order.speed, 1 / factor) ? [[key, composed({ ...order, speed: scaled(order.speed, 1 / factor) })]] : [];
  });
}

// Few words about a stage: its speed or its wait.
export function pace(orders: [string, string][]): string {
  for (const [key, text] of orders) {
    if (key === "wait") return text;
    const order = OWN.includes(key) ? null : parsed(text);
    if (order) return order.speed;
  }
  return "";
}

// A duration in seconds; 0 if it is none.
export function seconds(text: string): number {
  const found = QUANTITY.exec(text.trim());
  return found ? Number(found[1]) * ({ s: 1, min: 60, h: 3600, ms: 1e-3 }[found[2]] ?? 0) : 0;
}
