"""Cranes, slings and the block of a recorded plan.

Also the settings of a run in one or two lines: quantities asked for, omissions of its model, integration method.

The tolerance of the integrator limits the error of a step and says nothing about the model, so it is never called the
accuracy of a run.
"""

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

import msgspec

Data = dict[str, Any]


class HookMachine(NamedTuple):
    """A machine with hooks: its name, the dead load [kg] on each rope, and its configuration as texts by name."""

    name: str
    dead: dict[str, float]
    configuration: dict[str, str]


def cranes(plan: Data) -> list[HookMachine]:
    """Return all machines of a plan that have hooks."""
    found = []
    for machine in (machine for machine in plan.get("machines", []) if machine.get("hooks")):
        hooks = sorted(machine["hooks"], key=lambda hook: str(hook["rope"]))
        dead = {hook["rope"]: float(hook.get("below", 0.0) or hook.get("block_mass", 0.0)) for hook in hooks}
        found.append(HookMachine(machine["name"], dead, machine.get("configuration", {})))
    return found


def plan_of(attachments: Mapping[str, bytes]) -> Data:
    """Return the recorded plan as plain data; empty if the recording has no plan."""
    found: Data = msgspec.json.decode(attachments.get("resolved.json") or b"{}")
    return found


def unread(plan: Data) -> str:
    """Return a sentence if the plan comes from an earlier version, so that its cranes, slings and block cannot be read;
    "" otherwise."""
    if not plan or "machines" in plan:
        return ""
    return "of an earlier version: cranes, slings and block are not listed; run the scene again for them"


def ties(plan: Data) -> list[Data]:
    """Return the slings of all machines in a recorded plan."""
    return [tie for machine in plan.get("machines", []) for tie in machine.get("ties", [])]


def block(plan: Data) -> Data:
    """Return the lifted block with its start pose; empty if there is no block or more than one."""
    found = [(machine, cargo) for machine in plan.get("machines", []) for cargo in machine.get("cargo", [])]
    if len(found) != 1:
        return {}
    (machine, cargo), system = found[0], found[0][0]["system"]
    pose = next((x["q0"] for x in system["joints"] if x["child"] == cargo["body"]), [0.0] * 7)
    return {**cargo, "name": machine["name"], "pose": pose}


FACTS = ("asked", "modelled", "steps")  # names of the lines


def settings(run: Mapping[str, str]) -> dict[str, str]:
    """Return the settings in the facts of a run, by name, as lines of text; missing ones are omitted."""
    asked = run.get("asked", "")
    found = {}
    if asked:
        found["asked"] = f"{asked} to {run['accuracy']}" if run.get("accuracy") else asked
    if message := _answer(run.get("answer", "")) or run.get("modelled", ""):
        found["modelled"] = message
    steps = f"steps of {run['step']}" if run.get("step") else f"integrator's tolerance {run.get('tolerance', '')}"
    if run.get("step") or run.get("tolerance"):
        found["steps"] = ", ".join(part for part in (run.get("method", ""), steps) if part)
    return found


def _answer(text: str) -> str:
    """Return the measured errors of the quantities asked for, in words; "" if there are none."""
    try:
        return str(json.loads(text)["told"])
    except (ValueError, KeyError, TypeError):
        return ""
