"""A rope with mass, as a chain of lumps and massless ropes: what massless ropes neglect (C13, C13b)."""

import json
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel.analysis import NaturalMode, equilibrium, modes
from heavylift.kernel.description import Body, Joint, Line, Point, Rope, System
from small_scenes import G, X, Z, started

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[3] / "data" / "closed_forms.json").read_text())}
PIECES = 12
LUMPED = 2e-5  # relative: m_rope / m / (12 PIECES^2) = 1.2e-5 of the lumps, and what Rayleigh's quotient neglects
STRING = 0.01  # the closed form knows neither the weight of the rope (0.5 %) nor that the load gives way (0.2 %)


def chain(m: float, L: float, k: float, m_rope: float) -> System:
    """A load on a rope of stiffness k that is as long as L under its weight; each body moves along x and z."""
    step, piece = L / PIECES, m_rope / PIECES
    bodies, joints, ropes = [], [], []
    above = "world"
    for i in range(1, PIECES + 1):
        mass = piece if i < PIECES else m + piece / 2.0
        name = f"lump{i}" if i < PIECES else "load"
        under = (m + (PIECES - i + 0.5) * piece) * G  # the tension in the piece over it
        length = step - under / (k * PIECES)
        bodies += [Body(f"{name}-x", 0.0), Body(name, mass)]
        joints += [
            Joint(f"{name}-x", "prismatic", "world", f"{name}-x", axis=X),
            Joint(f"{name}-z", "prismatic", f"{name}-x", name, axis=Z, q0=(-i * step,)),
        ]
        ropes.append(Rope(f"rope{i}", (Line(Point(above), Point(name)),), k * PIECES * length, length))
        above = name
    return System(tuple(bodies), tuple(joints), ropes=tuple(ropes), gravity=G)


def along(oscillations: tuple[NaturalMode, ...], axis: str) -> list[float]:
    """Frequencies of the modes that move along an axis, lowest first [Hz]; joints alternate between x and z."""
    start = {"x": 0, "z": 1}[axis]
    return [o.frequency for o in oscillations if np.abs(o.shape[start::2]).max() > 0.5]


@pytest.fixture(scope="module")
def oscillations() -> tuple[NaturalMode, ...]:
    s = started(chain(**{key: FORMS["C13"]["given"][key] for key in ("m", "L", "k", "m_rope")}))
    equilibrium(s)
    return modes(s).oscillations


def test_a_heavy_rope_has_its_exact_axial_frequency(oscillations):
    x, want = FORMS["C13"]["given"], FORMS["C13"]["expected"]
    axial = along(oscillations, "z")[0]
    assert axial == pytest.approx(want["f_exact"], rel=LUMPED)
    s = started(System((Body("load", x["m"]),), (Joint("z", "prismatic", "world", "load", axis=Z, q0=(-60.2,)),),
                       ropes=(Rope("rope", (Line(Point("world"), Point("load")),), x["k"] * x["L"], x["L"]),),
                       gravity=G))  # fmt: skip
    equilibrium(s)
    massless = modes(s).oscillations[0].frequency
    assert massless == pytest.approx(want["f_massless"], rel=LUMPED)
    assert massless / axial - 1.0 == pytest.approx(want["m_ratio"] / 6.0, rel=0.01)


def test_a_heavy_rope_has_the_exact_frequencies_of_its_sway_and_its_first_string_mode(oscillations):
    want = FORMS["C13b"]["expected"]
    sway, string = along(oscillations, "x")[:2]
    assert 2.0 * np.pi * sway == pytest.approx(want["w"], rel=LUMPED)
    assert 2.0 * np.pi * sway / want["w0"] - 1.0 == pytest.approx(want["shift"], rel=0.01)
    assert string == pytest.approx(want["f_string_Hz"], rel=STRING)
