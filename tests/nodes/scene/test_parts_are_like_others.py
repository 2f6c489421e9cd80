"""An entry with the key `like` copies all keys of another entry that it does not state itself."""

from __future__ import annotations

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import parse
from heavylift.nodes.scenes import bundled
from lifting import unstated

LIFT = unstated(bundled()["lift"].read_text(encoding="utf-8"))
LOADERS = LIFT[LIFT.index("  loaders:") : LIFT.index("\n\n", LIFT.index("  loaders:"))]
FIRST, *OTHERS = LOADERS.splitlines()[1:]


def rigged(*loaders: str) -> str:
    return LIFT.replace(LOADERS, "\n".join(["  loaders:", *(f"    {x}" for x in loaders)]))


def test_lifting_beams_copied_by_the_key_like_differ_only_in_hook_and_lugs() -> None:
    like = rigged(
        "loader-1: {hook: crane H1, sling: 10 m, lugs: [P1, P2], upper mass: 12 t}",
        "loader-2: {like: loader-1, hook: crane H2, lugs: [Q1, Q2]}",
        "loader-3: {like: loader-2, hook: crane H3, lugs: [R1, R2], sling: 9 m}",
    )
    whole = rigged(
        "loader-1: {hook: crane H1, sling: 10 m, lugs: [P1, P2], upper mass: 12 t}",
        "loader-2: {hook: crane H2, sling: 10 m, lugs: [Q1, Q2], upper mass: 12 t}",
        "loader-3: {hook: crane H3, sling: 9 m, lugs: [R1, R2], upper mass: 12 t}",
    )
    assert parse(like, passing=True).scene == parse(whole, passing=True).scene
    for text in (like, whole):
        heavier = parse(text, overrides=["rig.loaders.loader-1.upper mass=14 t"], passing=True).scene.rig
        assert heavier is not None
        assert heavier.beams["loader-1"].parameters["upper mass"] == "14 t"
        assert (heavier.beams["loader-3"].parameters["upper mass"] == "14 t") is (text is like), (
            "what is like it follows"
        )


def test_a_sling_that_copies_another_by_the_key_like_takes_all_keys_that_it_does_not_state_itself() -> None:
    jib = bundled()["jib"].read_text(encoding="utf-8")
    two = "legs: {on: jib main, to: [N1, N2], length: 8 m, sling: {EA: 60 MN, breaking: 900 kN}}"
    start = jib.index("  legs:")
    made = (
        jib[:start]
        + f"  {two}\n  more: {{like: legs, to: [N3, N4], sling: {{EA: 50 MN}}}}\n"
        + jib[jib.index("\n\n", start) :]
    )
    legs, more = (parse(made, passing=True, followed=False).scene.rigging[name] for name in ("legs", "more"))
    assert (more.sling.EA, more.sling.breaking, more.lengths) == (50e6, 900e3, legs.lengths)  # type: ignore[union-attr]


def test_a_second_lift_copies_the_keys_of_another_lift_by_the_key_like() -> None:
    first = "a: {extends: jib, at: [9 m, 0 m], block: {mass: 10 t}}"
    text = f"heavylift: 1\nname: two\nlifts: {{{first}, b: {{like: a, at: [0 m, 99 m]}}}}\n"
    machines = parse(text, passing=True).plan.machines
    assert {m.name: m.system.bodies[0].mass for m in machines if "block" in m.name} == {
        "a-block": 10e3,
        "b-block": 10e3,
    }


BAD = {
    "loader-2: {like: loader-9, hook: crane H2, lugs: [Q1, Q2]}": "loader-2.like: there is no 'loader-9' here",
    "loader-2: {like: loader-2, hook: crane H2, lugs: [Q1, Q2]}": "'loader-2' refers to itself by 'like'",
    "loader-2: {like: loader-3, hook: crane H2, lugs: [Q1, Q2]}": "refers to itself by 'like'",
}


@pytest.mark.parametrize("entry", BAD)
def test_an_unknown_name_given_for_the_key_like_is_reported(entry: str) -> None:
    third = "loader-3: {like: loader-2, hook: crane H3, lugs: [R1, R2]}"
    with pytest.raises(SceneError) as error:
        parse(rigged("loader-1: {hook: crane H1, sling: 10 m, lugs: [P1, P2]}", entry, third), passing=True)
    assert BAD[entry] in str(error.value)


def test_a_fault_in_a_table_entry_that_others_copy_by_the_key_like_is_reported_at_one_line_only() -> None:
    with pytest.raises(SceneError) as error:
        parse(rigged("loader-1: {hook: crane H1, sling: 10 t, lugs: [P1, P2]}",
                     "loader-2: {like: loader-1, hook: crane H2, lugs: [Q1, Q2]}"), passing=True)  # fmt: skip
    lines = [line for line in str(error.value).splitlines() if "error: " in line]
    assert len({line.split(": error")[0] for line in lines}) == 1
