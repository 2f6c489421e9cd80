"""A lift by one crane of a bundled type, as `heavylift new` writes it, to be changed."""

from __future__ import annotations

from pathlib import Path

from heavylift.nodes.scene import LoadedScene, new_scene_with, parse
from heavylift.nodes.scene.text import library

TYPES = sorted(library())


def begun(crane: str, folder: Path) -> tuple[str, tuple[float, float, float]]:
    """A scene in which a crane of the type picks up a block, and half the block's length and its place in x and y."""
    mass, long, wide = (200, 30, 24) if crane.startswith(("goliath", "twin")) else (10, 6, 5)
    mass, long, wide = (100, 20, 10) if crane.startswith("mobile") else (mass, long, wide)
    head = "name,mass [t],size x [m],size y [m],size z [m]\n"
    (folder / "blocks.csv").write_text(f"{head}B,{mass},{long},{wide},4\n", encoding="utf-8")
    (text,) = new_scene_with("made", crane, "blocks.csv#B").values()
    x, y, _ = (float(word.split()[0]) for word in text.split("  at: [")[1].split("]")[0].split(","))
    return text, (long / 2, x, y)


class Lift:
    """A lift by one crane of a type, to be changed."""

    def __init__(self, text: str, block: tuple[float, float, float], folder: Path) -> None:
        self.text, (self.half, self.x, self.y), self.name = text, block, str(folder / "made.yaml")

    def read(self, *settings: str, text: str = "") -> LoadedScene:
        return parse(text or self.text, self.name, list(settings))

    def beginning(self, then: str) -> str:
        """As far as the block hangs, and then something else."""
        return self.text[: self.text.index("  - stage: down")] + then

    def moved(self, by: dict[str, str]) -> str:
        """An order that moves what hangs on the crane sideways."""
        found = {x.verb for machine in self.read().plan.machines for x in machine.actuators if x.verb in by}
        verb = next(verb for verb in by if verb in found)
        return f"crane: {verb} {by[verb]}"
