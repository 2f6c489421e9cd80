"""What touches without an order is red along the path at rest and in a run, on cranes of every type."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import pytest
from heavylift.coordinator.commands.common.app import app
from heavylift.coordinator.record import play
from heavylift.coordinator.verdict import near_at_rest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Check
from heavylift.nodes.models.commander import Machines, first_lugs, first_state
from heavylift.nodes.plan import UnhookSling
from heavylift.nodes.scene import LoadedScene, new_scene_with, parse
from heavylift.nodes.scene.text import library
from lifting import unstated
from typer.testing import CliRunner

HEAD = "name,mass [t],size x [m],size y [m],size z [m]\n"
UP = 1.0  # [m] that each lift goes up, in its stage 'up'


def size(crane: str) -> tuple[float, float]:
    if crane.startswith("mobile"):
        return 20.0, 10.0
    return (30.0, 24.0) if crane.startswith(("goliath", "twin")) else (6.0, 5.0)


@pytest.fixture(autouse=True)
def _here(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path_factory.getbasetemp())


def scene(crane: str, more: str = "", *edits: tuple[str, str]) -> LoadedScene:
    long, wide = size(crane)
    Path("blocks.csv").write_text(f"{HEAD}B,{100 if long > 6.0 else 10},{long},{wide},4\n", encoding="utf-8")
    (text,) = map(unstated, new_scene_with("made", crane, "blocks.csv#B").values())
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    return parse(text + more, "made.yaml")


def shelf(crane: str, gap: float) -> str:
    """A box over a corner of the block, so far above it."""
    block = scene(crane).scene.all_blocks["block"]
    (x, y, z), (a, b, c) = block.at, block.size
    place = f"[{x + a / 2} m, {y + b / 2} m, {z + c / 2 + gap + 0.25} m]"
    return f"\nobstacles: {{shelf: {{box: [0.6 m, 0.6 m, 0.5 m], at: {place}}}}}\n"


def met(found: list[Check]) -> list[Check]:
    return [f for f in found if f.state == "red" and f.quantity == "clearance"]


def at_rest(loaded: LoadedScene) -> list[Check]:
    return met([x for x in near_at_rest(loaded.plan, loaded.statics) if isinstance(x, Check)])


@pytest.mark.parametrize("crane", sorted(library()))
def test_a_contact_that_no_order_allows_gives_a_red_check_with_place_and_time(crane: str) -> None:
    gap = Random(crane).uniform(0.6, 0.9)
    assert at_rest(scene(crane)) == []
    loaded = scene(crane, shelf(crane, gap))
    (found,) = at_rest(loaded)
    assert (found.subject, found.stage) == ("block and shelf", "up")
    assert found.sentence.startswith("the block touched shelf, which nothing orders")
    up = next(x.t for x in loaded.statics.states if x.stage == "up")
    assert found.t == pytest.approx(up + gap * 60.0, abs=1.0)  # at 1 m/min, but for ramps
    for says in ("[[block, shelf]]", "[[shelf, block]]"):
        assert at_rest(scene(crane, f"{shelf(crane, gap)}may touch: {says}\n")) == []
    stages = [("  - stage: up\n", "  - stage: up\n    may touch: [[block, shelf]]\n")]
    assert at_rest(scene(crane, shelf(crane, gap), *stages)) == []
    other = [("  - stage: lift off\n", "  - stage: lift off\n    may touch: [[block, shelf]]\n")]
    assert len(at_rest(scene(crane, shelf(crane, gap), *other))) == 1


@pytest.mark.parametrize("crane", ["goliath-840", "overhead-100"])
def test_a_run_reports_the_same_forbidden_contacts_as_the_command_check(crane: str) -> None:
    gap = Random(crane).uniform(0.6, 0.9)
    touches = play(scene(crane, shelf(crane, gap)).plan).verdict
    assert touches.red
    assert "the block touched shelf, which nothing orders" in str(touches.findings)
    free = play(scene(crane, f"{shelf(crane, gap)}may touch: [[block, shelf]]\n").plan).verdict
    assert "shelf" not in str([f for f in free.findings if f.state == "red"])


def test_the_command_check_exits_with_1_if_bodies_touch_without_an_order_that_allows_it(tmp_path: Path) -> None:
    for name, more, code in (("a", "", 1), ("b", "may touch: [[block, wall]]\n", 0)):
        wall = "obstacles: {wall: {box: [1 m, 30 m, 30 m], at: [-15.5 m, 20 m, 15 m]}}\n"
        orders = 'actions: [{hall: "hoist 1 m/min until lifted"}, {hall travelling: "travel 10 m/min by 2 m"}]\n'
        (tmp_path / f"{name}.yaml").write_text(f"extends: hall\nname: {name}\n{wall}{more}{orders}", encoding="utf-8")
        message = CliRunner().invoke(app, ["check", str(tmp_path / f"{name}.yaml")])
        assert message.exit_code == code, message.output
        assert ("red: the block touched wall" in message.output) == bool(code)
        assert re.search(r"not checked at rest from [\d:.]+ on: 'block-wall' touches at", message.output)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("may touch: [[block, shlef]]\n", r"made\.yaml:\d+:\d+: error: may touch\[0\]\[?1?\]?.*no 'shlef'"),
        ("may touch: [[blok, ground]]\n", "there is no 'blok' that could touch anything"),
        ("may touch: [[block]]\n", "may touch"),
        ("may tuch: [[block, ground]]\n", "did you mean 'may touch'"),
    ],
)
def test_an_order_that_allows_contact_with_an_unknown_object_is_refused(text: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        scene("jib-60", shelf("jib-60", 0.8) + text)


def test_a_stage_that_allows_contact_with_an_object_that_does_not_exist_is_refused() -> None:
    for says, message in (
        ("may touch: [[block, shlef]]", "did you mean 'shelf'"),
        ("may tuch: [[block, shelf]]", "'may touch'"),
    ):
        with pytest.raises(SceneError, match=message):
            scene("jib-60", shelf("jib-60", 0.8), ("  - stage: up\n", f"  - stage: up\n    {says}\n"))


@pytest.mark.parametrize("crane", sorted(library()))
def test_unhooking_a_hanging_load_is_an_error_in_the_scene_and_is_refused_in_a_run(crane: str) -> None:
    """At rest it is an error at its line; a commander refuses it, too, whoever orders it, unless the load stands."""
    loaded = scene(crane)
    names = [*loaded.scene.rigging, *(loaded.scene.rig.beams if loaded.scene.rig else ())]
    orders = "".join(f"    {name}: unhook\n" for name in names)
    with pytest.raises(SceneError, match="no taut sling is left: the block would fall"):
        scene(crane, "", ("  - stage: down\n", f"  - stage: off\n{orders}  - stage: down\n"))
    machines = Machines(loaded.plan)
    state, lugs = first_state(machines.parts), first_lugs(machines.parts)
    ties = [tie.rope for machine in machines.parts for tie in machine.ties]
    state.ropes |= dict.fromkeys(ties, "taut")
    all_of_them = [UnhookSling(sling=rope) for rope in ties]
    assert machines.lets_fall(all_of_them, state, lugs) == ""
    state.grounded.clear()
    assert machines.lets_fall(all_of_them, state, lugs).startswith(
        "block hangs only in slings to be unhooked and would fall"
    )
    assert machines.lets_fall([UnhookSling(sling=rope, parted=True) for rope in ties], state, lugs) == ""
    state.ropes |= dict.fromkeys(ties, "slack")
    assert machines.lets_fall(all_of_them, state, lugs) == ""


@pytest.mark.parametrize("crane", sorted(library()))
def test_the_order_to_stop_the_cranes_stops_all_their_drives_and_hooks(crane: str) -> None:
    def stopped(target: str) -> set[str]:
        loaded = scene(crane, "", ("  - stage: down\n", f"  - stage: stop\n    {target}: stop\n  - stage: down\n"))
        return {x.actuator for x in next(a for a in loaded.plan.actions if a.stage == "stop").orders}  # type: ignore[union-attr]

    assert stopped("cranes") == stopped("all cranes") == stopped("crane")
    hooks = {hook.rope for machine in Machines(scene(crane).plan).parts for hook in machine.hooks}
    assert hooks
    assert hooks <= stopped("cranes")


@pytest.mark.parametrize("crane", sorted(library()))
def test_a_block_whose_mass_does_not_fit_its_volume_is_reported(crane: str) -> None:
    draw, (long, wide) = Random(crane), size(crane)
    for density in (draw.uniform(0.01, 19.0), draw.uniform(21.0, 100.0)):
        mass = density * long * wide * 4.0 / 1e3
        loaded = scene(crane, "", ("  from: blocks.csv#B\n", f"  from: blocks.csv#B\n  mass: {mass} t\n"))
        message = [f for f in loaded.findings if f.quantity == "geometry"]
        assert [f.word for f in message] == ["warning"] * (density < 20.0)
        assert all(f.value == pytest.approx(density) and "light frames, assumed" in f.sentence for f in message)
