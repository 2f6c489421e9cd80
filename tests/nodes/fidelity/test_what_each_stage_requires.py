"""Choices are made again in mid-run: what is unhooked or in the air leaves the equations, stage by stage."""

from heavylift.coordinator.run.stages import page, required
from heavylift.nodes.scene import load

TURNOVER = required(load("turnover"))


def test_pads_are_required_on_the_ground_and_slings_while_they_are_hooked():
    rows = {x.stage: (x.islands, x.ropes, x.pads) for x in TURNOVER}
    assert rows["load"] == (1, 18, 8)
    assert rows["hoist"] == (1, 18, 0)  # to 30 m
    assert rows["unhook B"] == rows["rigging"] == (1, 14, 0)
    assert rows["hook C"] == (1, 18, 0)
    assert rows["lower"] == (1, 18, 8)  # 0.5 m above its stools


def test_what_is_not_required_saves_operations():
    cost = {x.stage: x.operations for x in TURNOVER}
    assert cost["unhook B"] < cost["hoist"] < cost["load"]
    assert cost["hook C"] == cost["hoist"]
    assert cost["lower"] == cost["load"]


def test_the_page_shows_the_stages_that_change_something():
    lines = page(TURNOVER).splitlines()
    assert lines[0].split()[-4:] == ["islands", "ropes", "pads", "operations"]
    assert [line[2:30].strip() for line in lines[1:]] == ["at the start", "hoist", "unhook B", "hook C", "lower"]


def test_a_scene_without_a_block_has_no_stages():
    assert required(load("arm")) == []
