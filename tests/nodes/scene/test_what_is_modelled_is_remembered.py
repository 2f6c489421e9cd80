"""What a scene's question requires is worked out once; the second load reads it, and finds the same."""

import pytest
from heavylift.kernel import cache
from heavylift.nodes.plan import ASKABLE
from heavylift.nodes.scene import load, loaded_scene, loading


@pytest.fixture
def kept(monkeypatch):
    """Files of the cache, none of another test."""
    files = {}
    monkeypatch.setattr(cache, "read_cached", lambda name: files.get(name, b""))
    monkeypatch.setattr(cache, "write_cached", files.__setitem__)
    monkeypatch.setattr(loading, "read_cached", lambda name: b"")  # so that the scene is built again
    monkeypatch.setattr(loading, "write_cached", lambda name, content: None)
    return files


@pytest.mark.parametrize("ask", ["rope tension", ", ".join(ASKABLE)])
def test_a_verdict_comes_back_as_it_was(ask, kept, monkeypatch):
    settings = [f"ask=[{ask}]", "accuracy=1 %"]
    first = load("lift", settings)
    monkeypatch.setattr(loaded_scene, "choose", None)
    again = load("lift", settings)
    assert again.verdict == first.verdict
    assert str(again.verdict) == str(first.verdict)
    assert again.plan == first.plan


@pytest.mark.parametrize(
    "setting", ["accuracy=2 %", "fidelity.girder=elastic", "method=dopri5", "ask=[swing]", "gravity=9.8 m/s2"]
)
def test_another_question_or_scene_has_a_verdict_of_its_own(setting, kept):
    load("lift", ["ask=[rope tension]", "accuracy=1 %"])
    before = {name for name in kept if name.endswith(".verdict")}
    load("lift", ["ask=[rope tension]", "accuracy=1 %", setting])
    assert len(before) == 1
    assert len({name for name in kept if name.endswith(".verdict")}) == 2


def test_what_cannot_be_read_is_made_again(kept):
    settings = ["ask=[rope tension]", "accuracy=1 %"]
    first = load("lift", settings)
    for name in kept:
        kept[name] = b"not what it was"
    assert load("lift", settings).verdict == first.verdict
