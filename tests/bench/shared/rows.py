"""Output of all scripts of tests/bench: two options, and one row for each figure.

    python tests/bench/NAME.py [--json] [--short]

`--short` takes small sizes along the same code: it shows that a script works, its figures mean nothing.
"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Mapping
from types import ModuleType
from typing import Any

import msgspec

JSON, SHORT = "--json" in sys.argv, "--short" in sys.argv


class Row(msgspec.Struct, forbid_unknown_fields=True):
    """One figure; `target` bounds the ratio to the peer or, if the row has none, the value."""

    name: str
    value: float
    unit: str
    peer: str | None
    peer_value: float | None
    ratio: float | None
    target: float | None
    met: bool | None  # None: no target, or its peer is not installed


def options(doc: str, own: Mapping[str, dict[str, Any]] | None = None) -> argparse.Namespace:
    """Options of a script: those of its own by name, with the arguments of `add_argument`, and the two of all."""
    parser = argparse.ArgumentParser(description=doc.partition("\n")[0], allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print one JSON object a line, one for each figure")
    parser.add_argument("--short", action="store_true", help="small sizes, a few seconds: a check, no measurement")
    for name, how in (own or {}).items():
        parser.add_argument(name, **how)
    return parser.parse_args()


def peer_module(module: str, name: str, install: str) -> ModuleType | None:
    """A peer; None, and one sentence on standard error, where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        print(f"{name} is left out ({error}): install it with {install}", file=sys.stderr)
        return None


def row(
    name: str,
    value: float,
    unit: str = "",
    peer: str | None = None,
    peer_value: float | None = None,
    *,
    at_most: float | None = None,
    at_least: float | None = None,
    absolute: bool = False,
) -> None:
    """Print a figure; `absolute`: the target bounds the value although there is a peer."""
    ratio = value / peer_value if peer_value else None
    target, checked = at_least if at_most is None else at_most, value if peer is None or absolute else ratio
    met = None
    if target is not None and checked is not None:
        met = bool(checked >= target if at_most is None else checked <= target)
    figures = [None if x is None else float(f"{x:.6g}") for x in (value, peer_value, ratio, target)]
    message = Row(name, figures[0] or 0.0, unit, peer, *figures[1:], met)
    print(
        msgspec.json.encode(message).decode() if JSON else line(message, "<= " if at_least is None else ">= "),
        flush=True,
    )


def line(row: Row, bound: str = "") -> str:
    """A figure as text; `bound`: the sign of its target."""
    message = f"{row.name:<62} {row.value:>10.4g} {row.unit:<9}"
    if row.peer_value is not None:
        message += f" {row.peer} {row.peer_value:.4g}" + (f", ratio {row.ratio:.3g}" if row.ratio is not None else "")
    elif row.peer:
        message += f" {row.peer}: not measured"
    if row.target is not None:
        verdict = {True: "met", False: "MISSED", None: "not checked"}[row.met]
        message += f"  target {bound}{row.target:.4g}: {verdict}"
    return message.rstrip()
