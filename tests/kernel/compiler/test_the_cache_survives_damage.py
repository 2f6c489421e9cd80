"""Cached object files are reused only for equal structures and checked before use."""

from dataclasses import replace

import pytest
from heavylift.kernel import cache_folder
from heavylift.kernel.description import Body, Joint, JointSpring, System, Threshold
from heavylift.kernel.simulation import Simulation
from heavylift.kernel.simulation.native import native_state
from small_scenes import SECOND, X, slider, started


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(native_state, "MOST_LOADED", 0)
    monkeypatch.setattr(native_state, "_loaded", {})
    return tmp_path / "cache"


def falls(s: Simulation) -> None:
    s.start()
    s.run(SECOND)
    s.interrupt(SECOND)
    assert s.state[0] == pytest.approx(-9.80665 / 2, rel=1e-12)


def test_a_second_start_of_the_same_system_compiles_nothing_and_gives_bit_identical_results(folder):
    first, second = Simulation(slider()), Simulation(slider())
    assert cache_folder() == folder
    assert (first.native.code.cached, second.native.code.cached) == (False, True)
    for s in (first, second):
        falls(s)
    assert first.X.tobytes() == second.X.tobytes()
    assert [p.suffix for p in folder.iterdir()] == [".o"]


@pytest.mark.parametrize(
    "damage",
    [
        lambda code: b"",
        lambda code: code[: len(code) // 2],
        lambda code: b"not an object file",
        lambda code: code[:200] + bytes([code[200] ^ 1]) + code[201:],
        lambda code: code[:-1],
        lambda code: bytes(len(code)),
    ],
    ids=["empty", "half", "text", "one bit", "one byte short", "zeros"],
)
def test_machine_code_is_compiled_again_if_its_cached_file_is_damaged(folder, damage):
    Simulation(slider())
    (path,) = folder.iterdir()
    code = path.read_bytes()
    path.write_bytes(damage(code))
    s = Simulation(slider())
    assert not s.native.code.cached
    falls(s)
    assert path.read_bytes() == code


def test_a_scene_runs_with_an_unwritable_cache_folder(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("HEAVYLIFT_CACHE", str(tmp_path / "file"))
    falls(Simulation(slider()))


def test_scenes_that_differ_only_in_masses_and_lengths_share_machine_code(folder):
    """Other numbers are other parameters; 0, 1 and -1 are structure."""
    Simulation(slider(mass=2.0))
    assert Simulation(slider(mass=3.0)).native.code.cached
    assert not Simulation(slider(mass=1.0)).native.code.cached


def two(first: str, second: str, spring: str) -> System:
    """Two guides; names and the joint with the spring vary."""
    joints = tuple(Joint(n, "prismatic", "world", f"on-{n}", axis=X, q0=(1.0,)) for n in (first, second))
    bodies = tuple(Body(f"on-{n}", 2.0) for n in (first, second))
    return System(bodies, joints, springs=(JointSpring("spring", spring, 8.0),))


def test_listing_the_same_names_in_another_order_gives_another_compiled_program(folder):
    for scene, pulled in ((two("a", "b", "a"), 0), (two("b", "a", "a"), 1)):
        s = started(scene)
        f = s.X[s.method.layout.at["f"]][2:4]
        assert (f[pulled], f[1 - pulled]) == (-4.0, 0.0)


def test_swapping_the_names_of_two_bodies_gives_another_compiled_program(folder):
    """A threshold on the angle of `a` looks at the body of that name."""
    found = []
    for names in (("a", "b"), ("b", "a")):
        bodies = tuple(Body(n, 0.0, inertia=((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0))) for n in names)
        joints = tuple(Joint(f"j{i}", "revolute", "world", n, axis=X, q0=(-0.5 * i,)) for i, n in enumerate(names))
        thresholds = (Threshold("t", "angle", of="a"), Threshold("other", "angle", of="b"))
        s = started(System(bodies, joints, thresholds=thresholds))
        s.switches.watch("t", 0.25, True)
        s.settle()
        found.append(bool(s.events.fallen))
    assert found == [False, True]


def test_adding_a_force_to_a_system_gives_another_compiled_program(folder):
    Simulation(slider())
    spring = JointSpring("s", "load-guide", 2.0)
    assert not Simulation(replace(slider(), springs=(spring,))).native.code.cached
    assert Simulation(replace(slider(), springs=(replace(spring, k=5.0),))).native.code.cached
