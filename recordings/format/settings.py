"""What a run says of itself in one or two lines: what it was asked, what its model leaves out, how it was integrated.

The tolerance of the integrator bounds the error of a step and says nothing of the model, so it is never called the
accuracy of a run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

FACTS = ("asked", "modelled", "steps")  # names of the lines


def settings(run: Mapping[str, str]) -> dict[str, str]:
    """The lines by name, from the facts of a run; those are left out of which it says nothing."""
    asked = run.get("asked", "")
    found = {}
    if asked:
        found["asked"] = f"{asked} to {run['accuracy']}" if run.get("accuracy") else asked
    if told := _answer(run.get("answer", "")) or run.get("modelled", ""):
        found["modelled"] = told
    steps = f"steps of {run['step']}" if run.get("step") else f"integrator's tolerance {run.get('tolerance', '')}"
    if run.get("step") or run.get("tolerance"):
        found["steps"] = ", ".join(part for part in (run.get("method", ""), steps) if part)
    return found


def _answer(text: str) -> str:
    """What was measured for what was asked, in words."""
    try:
        return str(json.loads(text)["told"])
    except (ValueError, KeyError, TypeError):
        return ""
