"""Checks of samples in blocks give the findings of checks of single samples."""

import numpy as np
import pytest
from heavylift.kernel import KernelError
from heavylift.kernel.description import Beam, Body, Flexible, InputSignal, Joint, Load, Point, System
from heavylift.kernel.simulation import SampleRecorder
from small_scenes import SECOND, hand_over, started

L, EI = 10.0, 1e6
EULER = np.pi**2 * EI / (4.0 * L * L)  # of a cantilever [N]
STANDING = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))  # x upwards


def column(*pressed: tuple[float, float]) -> System:
    """Compressed to parts of its Euler load, at times."""
    times, parts = zip(*pressed, strict=True)
    push = Load("push", Point("jib", (L, 0.0, 0.0)), (0.0, 0.0, -EULER), signal=InputSignal(times=times, values=parts))
    body = Body("jib", 0.0, flexible=Flexible(2, Beam(L, 100.0, EI_y=EI, EI_z=EI, elements=8), damping=1.0, loads=(L,)))
    return System((body,), (Joint("root", "fixed", "world", "jib", R_PJ=STANDING),), forces=(push,), gravity=0.0)


def run(system: System, block: int) -> tuple[SampleRecorder, list, str]:
    """Samples at 100 Hz, taken so many at once."""
    s = started(system, method="radau5", tolerance=1e-6, sample_ns=SECOND // 100)
    s.native.set(rows=float(block))
    sentence = ""
    try:
        hand_over(s, 4 * SECOND)
    except KernelError as error:
        sentence = str(error)
    return s.recorder, s.notes, sentence


@pytest.mark.parametrize("most", [0.3, 0.7, 1.2])
def test_the_kernel_finds_the_same_peaks_and_events_in_samples_checked_in_blocks_and_one_by_one(most):
    system = column((0.0, 0.0), (1.0, 0.0), (1.5, most), (2.0, 0.0), (3.0, 0.0), (3.5, most), (9.0, most))
    one, many = run(system, 1), run(system, 500)
    assert (one[1], one[2]) == (many[1], many[2])
    assert [t for t, _ in one[0].rows] == [t for t, _ in many[0].rows]
    for (_, a), (_, b) in zip(one[0].rows, many[0].rows, strict=True):
        assert np.array_equal(a, b)
    assert bool(many[1]) == (most > 0.5)
    assert ("buckling load" in many[2]) == (most > 1.0)


def test_blocks_without_findings_are_not_checked_sample_by_sample(monkeypatch):
    looked = []
    kept = SampleRecorder.keep
    monkeypatch.setattr(SampleRecorder, "keep", lambda self, t_ns, row: (looked.append(t_ns), kept(self, t_ns, row)))
    recorder, _, _ = run(column((0.0, 0.0), (9.0, 0.001)), 500)
    assert len(recorder.rows) > 400
    assert looked == [0]
