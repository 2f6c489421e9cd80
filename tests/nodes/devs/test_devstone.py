"""DEVStone (Glinsky and Wainer 2005; Cardenas et al.): structure and exact counts of all four kinds.

The whole run happens at t = 0; a seeder puts one event into every in port of the root.
"""

from itertools import product

import pytest
from devs_stories import Item, Relay, coupled
from heavylift.nodes.devs import Atomic, Bag, Coupled, In, Out, Simulator


class Stone(Atomic):
    i, o = In(Item), Out(Item)

    def start(self) -> None:
        self.ints = self.exts = self.events = 0

    def external(self, e: int, x: Bag) -> None:
        self.exts += 1
        self.events += len(x[self.i])
        self.hold_in(0)

    def output(self) -> None:
        self.o.send(Item(0))

    def internal(self) -> None:
        self.ints += 1
        self.passivate()


def stones(model: Coupled, names: list[str]) -> list[Stone]:
    return [model.add(Stone(name)) for name in names]


def build(kind: str, w: int, d: int) -> Coupled:
    two = kind in ("HO", "HOmod")
    model = Coupled(f"c{d}")
    i, o = model.add_in("i", Item), model.add_out("o", Item)
    i2 = model.add_in("i2", Item) if two else i
    o2 = model.add_out("o2", Item) if kind == "HO" else o
    if d == 1:
        stone = model.add(Stone("a"))
        model.connect(i, stone.i)
        model.connect(stone.o, o)
        return model
    inner = model.add(build(kind, w, d - 1))
    model.connect(i, inner.ports["i"])
    model.connect(inner.ports["o"], o)
    if kind != "HOmod":
        row = stones(model, [f"a{n}" for n in range(w - 1)])
        if kind == "HO":
            model.connect(i, inner.ports["i2"])
        for n, stone in enumerate(row):
            model.connect(i2, stone.i)
            if kind == "HO":
                model.connect(stone.o, o2)
            if kind != "LI" and n:
                model.connect(row[n - 1].o, stone.i)
        return model
    rows = [stones(model, [f"r1_{n}" for n in range(w - 1)])]
    rows += [stones(model, [f"r{r}_{n}" for n in range(w - max(r - 1, 1))]) for r in range(2, w + 1)]
    for stone in rows[0]:
        model.connect(i2, stone.i)
        model.connect(stone.o, inner.ports["i2"])
    for r, row in enumerate(rows[1:], start=2):
        for n, stone in enumerate(row):
            if n == 0:
                model.connect(i2, stone.i)
            for above in rows[0] if r == 2 else [rows[r - 2][n + 1]]:
                model.connect(stone.o, above.i)
    return model


def couplings(model: Coupled) -> tuple[int, int, int]:
    """EIC, IC, EOC of the whole tree."""
    eic = sum(s.owner is model for s, _ in model.couplings)
    eoc = sum(t.owner is model for _, t in model.couplings)
    below = [couplings(c) for c in model.children.values() if isinstance(c, Coupled)]
    here = (eic, len(model.couplings) - eic - eoc, eoc)
    return tuple(map(sum, zip(here, *below, strict=True)))  # type: ignore[return-value]


def structure(kind: str, w: int, d: int) -> tuple[int, tuple[int, int, int]]:
    if kind == "HOmod":
        ic = (w - 1) ** 2 + (w - 1) + (w - 1) * (w - 2) // 2
        atomics = (w - 1 + w * (w - 1) // 2) * (d - 1) + 1
        return atomics, ((2 * (w - 1) + 1) * (d - 1) + 1, ic * (d - 1), d)
    chain = 0 if kind == "LI" else max(w - 2, 0) * (d - 1)
    eic = ((w + 1) if kind == "HO" else w) * (d - 1) + 1
    return (w - 1) * (d - 1) + 1, (eic, chain, w * (d - 1) + 1 if kind == "HO" else d)


def counts(kind: str, w: int, d: int) -> tuple[int, int, int]:
    """Internal and external transitions and events."""
    if kind != "HOmod":
        n = (w - 1) * (d - 1) + 1 if kind == "LI" else (d - 1) * w * (w - 1) // 2 + 1
        return n, n, n
    s = (d - 1) + (w - 1) * (d - 1) * (d - 2) // 2
    n = 1 + (d - 1) * (w - 1) ** 2 + (w - 1) * (w + 2) * s // 2
    if w == 1 or d == 1:
        return n, n, 1
    a = (d - 2) + (w - 1) * (d - 2) * (d - 1) // 2
    events = 1 + 2 * (w - 1) + 2 * a * (w - 1) ** 2 + (a + 1) * ((w - 1) ** 2 + (w - 1) * (w - 2) // 2)
    return n, n, events


@pytest.mark.parametrize("kind", ["LI", "HI", "HO", "HOmod"])
def test_models_of_the_devstone_benchmark_have_their_exact_structure_and_event_counts(kind: str) -> None:
    """64 sizes of each kind, 256 in all: atomics, couplings by their sort, transitions, events."""
    for w, d in product(range(1, 9), range(1, 9)):
        assert measured(kind, w, d) == (*structure(kind, w, d), counts(kind, w, d)), (w, d)


@pytest.mark.parametrize(("kind", "n"), [("LI", 2402), ("HI", 60026), ("HO", 60026)])
def test_published_devstone_sizes_are_reproduced(kind: str, n: int) -> None:
    assert measured(kind, 50, 50)[2] == (n, n, n)


def measured(kind: str, w: int, d: int) -> tuple[int, tuple[int, int, int], tuple[int, int, int]]:
    model, seed = build(kind, w, d), Relay("seed", first=0)
    ports = [(seed.out, port) for name, port in model.ports.items() if name in ("i", "i2")]
    simulator = Simulator(coupled("r", [seed, model], *ports))
    simulator.start()
    simulator.run()
    all_ = [m for m in simulator.atomics if isinstance(m, Stone)]
    total = (sum(m.ints for m in all_), sum(m.exts for m in all_), sum(m.events for m in all_))
    return len(all_), couplings(model), total
