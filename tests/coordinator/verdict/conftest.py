"""Lifts by a crane of each bundled type."""

from __future__ import annotations

from pathlib import Path

import pytest
from lift_of_a_type import TYPES, Lift, begun


@pytest.fixture(params=TYPES)
def lift(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Lift:
    monkeypatch.chdir(tmp_path)
    return Lift(*begun(request.param, tmp_path), tmp_path)
