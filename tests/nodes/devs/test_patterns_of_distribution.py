"""The patterns by which PythonPDEVS tests distribution: one expected log, nested, flat and cut into 2 to 5 nodes."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from devs_stories import Generator, Item, Relay, Sink, coupled
from heavylift.nodes.devs import Coupled, Model, OutPort, seconds
from nested_flat_cut import logs_of


def boxed(model: Model, levels: int) -> Coupled:
    """A model with ports `into` and `out` inside as many coupled models, the outmost of which is box 1."""
    name = model.name
    for level in range(levels, 0, -1):
        box = coupled(f"{name}-{level}", [model])
        for key, port in model.ports.items():
            if isinstance(port, OutPort):
                box.connect(port, box.add_out(key, Item))
            else:
                box.connect(box.add_in(key, Item), port)
        model = box
    assert isinstance(model, Coupled)
    return model


def line(*models: Model) -> Coupled:
    """Each model's `out` to the next one's `into`."""
    root = coupled("r", models)
    for source, target in pairwise(models):
        root.connect(source.ports["out"], target.ports["into"])
    return root


def dual(levels: int) -> Coupled:
    g, s = Generator("g", seconds(1), count=2), Sink("s")
    west, east = (boxed(Relay(name, seconds(0.5)), levels) for name in ("w", "x"))
    root = coupled("r", [g, west, east, s])
    for branch in (west, east):
        root.connect(g.out, branch.ports["into"])
        root.connect(branch.ports["out"], s.into)
    return root


def multi() -> Coupled:
    g, h, s = Generator("g", seconds(1), count=2), Generator("h", seconds(2), count=1), Sink("s")
    return coupled("r", [g, h, s], (h.out, s.into), (g.out, s.into))


def ring() -> Coupled:
    a, b, c = Relay("a", 0, first=5), Relay("b", 0), Relay("c", seconds(1))
    return coupled("r", [a, b, c], (a.out, b.into), (b.out, c.into), (c.out, a.into))


PATTERNS: dict[str, tuple[Callable[[], Coupled], list[str]]] = {
    "normal": (
        lambda: line(Generator("g", seconds(1), count=2), Relay("p", seconds(0.3)), Sink("s")),
        ["1.0 g i", "1.0 p e 0", "1.3 p i", "1.3 s e 0", "2.0 g i", "2.0 p e 1", "2.3 p i", "2.3 s e 1"],
    ),
    "confluent": (
        lambda: line(Generator("g", seconds(1), count=3), Relay("p", seconds(1)), Sink("s")),
        [
            *("1.0 g i", "1.0 p e 0", "2.0 g i", "2.0 p c 1", "2.0 s e 0"),
            *("3.0 g i", "3.0 p c 2", "3.0 s e 1", "4.0 p i", "4.0 s e 2"),
        ],
    ),
    "zero lookahead": (
        lambda: line(Generator("g", seconds(1), count=1), Relay("p"), Relay("q"), Relay("r"), Sink("s")),
        ["1.0 g i", "1.0 p e 0", "1.0+1 p i", "1.0+1 q e 0", "1.0+2 q i", "1.0+2 r e 0", "1.0+3 r i", "1.0+3 s e 0"],
    ),
    "dual": (
        lambda: dual(1),
        [
            *("1.0 g i", "1.0 w-1.w e 0", "1.0 x-1.x e 0", "1.5 s e 0 0", "1.5 w-1.w i", "1.5 x-1.x i"),
            *("2.0 g i", "2.0 w-1.w e 1", "2.0 x-1.x e 1", "2.5 s e 1 1", "2.5 w-1.w i", "2.5 x-1.x i"),
        ],
    ),
    "nested": (
        lambda: line(Generator("g", seconds(1), count=1), boxed(Relay("p", seconds(0.5)), 3), boxed(Sink("s"), 2)),
        ["1.0 g i", "1.0 p-1.p-2.p-3.p e 0", "1.5 p-1.p-2.p-3.p i", "1.5 s-1.s-2.s e 0"],
    ),
    "multiple inputs": (multi, ["1.0 g i", "1.0 s e 0", "2.0 g i", "2.0 h i", "2.0 s e 1 0"]),
    "ring with delays of zero": (
        ring,
        [
            *("0.0 a i", "0.0 b e 5", "0.0+1 b i", "0.0+1 c e 5", "1.0 a e 5", "1.0 c i"),
            *("1.0+1 a i", "1.0+1 b e 5", "1.0+2 b i", "1.0+2 c e 5"),
        ],
    ),
}


@pytest.mark.parametrize("name", PATTERNS)
def test_fan_in_and_fan_out_of_messages_give_equal_logs_in_nested_and_flat_and_distributed_simulators(
    name: str,
) -> None:
    build, expected = PATTERNS[name]
    for log in logs_of(build, seconds(2) if name.startswith("ring") else seconds(10)):
        message = []
        for tag, path, kind, bag, _ in log:
            k = f"+{tag.k}" if tag.k else ""
            heard = "".join(f" {item.n}" for _, item in bag if isinstance(item, Item))
            message.append(f"{tag.t / 1e9}{k} {path.removeprefix('r.')} {kind[0]}{heard}")
        assert message == expected


def branches(levels: int) -> list[list[tuple[object, ...]]]:
    """The three logs of the dual pattern, with the atomics' own names."""
    logs = logs_of(lambda: dual(levels), seconds(9))
    return [[(line.tag, line.path.rsplit(".", 1)[1], *line[2:]) for line in log] for log in logs]


def test_branches_nested_three_coupled_models_deep_make_the_same_transitions_as_one_branch() -> None:
    """The same branches three boxes deep: the same times, kinds and bags."""
    assert branches(3) == branches(1)
    assert len(branches(3)[0]) == 12
