"""Contact points of balls and boxes against the distance of convex sets; rates of contact rows against motion."""

import numpy as np
import pytest
from heavylift.kernel.constraints.contact import candidates, frames
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

TOUCH = 1e-6  # [m] distance to which the least squares of SciPy sees two boxes touch
DERIVATIVE = 1e-7  # of central differences of motions of order one


LEVEL = np.eye(3)


def body(R=LEVEL, p=(0.0, 0.0, 0.0), w=(0.0, 0.0, 0.0), v=(0.0, 0.0, 0.0)):
    """(21,) a body about its own origin."""
    return np.concatenate([np.ravel(R), p, np.zeros(3), w, v])


def box(size, centre=(0.0, 0.0, 0.0)):
    return np.array([*centre, *np.eye(3).ravel(), *(0.5 * np.array(size))])


def distance(size_a, A, size_b, B):
    """Of two boxes, as bounded least squares over their points."""
    M = np.hstack([np.reshape(A[:9], (3, 3)), -np.reshape(B[:9], (3, 3))])
    half = 0.5 * np.array([*size_a, *size_b])
    return np.sqrt(2.0 * lsq_linear(M, B[9:12] - A[9:12], (-half, half), tol=1e-14).cost)


def first_touch(witness, start, direction, far):
    """Way along a direction to where a witness falls below zero."""
    lo, hi = 0.0, far
    steps = np.linspace(0.0, far, 400)
    hi = next(s for s in steps if min(witness(start + s * direction)) < 0.0)
    lo = hi - steps[1]
    while hi - lo > 1e-13:
        middle = 0.5 * (lo + hi)
        lo, hi = (lo, middle) if min(witness(start + middle * direction)) < 0.0 else (middle, hi)
    return hi


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.large(beyond=1)
def test_boxes_touch_when_their_distance_becomes_zero(seed):
    """Two boxes in random attitude approach on a random line: first witness = first touch, never earlier or later."""
    rng = np.random.default_rng(seed)
    a, b = rng.uniform(0.5, 2.0, 3), rng.uniform(0.5, 2.0, 3)
    R_A, R_B = Rotation.random(2, random_state=seed).as_matrix()
    B = body(R_B)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    start = -5.0 * direction + 0.3 * rng.normal(size=3)

    def witness(p):
        return gaps(candidates.box_box(box(a), box(b), body(R_A, p), B))

    path = first_touch(witness, start, direction, 6.0)
    assert distance(a, body(R_A, start + path * direction), b, B) < TOUCH
    assert distance(a, body(R_A, start + (path - 1e-3) * direction), b, B) > 10 * TOUCH


def gaps(witnesses):
    return [gap for gap, _ in witnesses]


def which(witnesses, below):
    w = np.array(gaps(witnesses))
    return {"vertices of A": int((w[:8] < below).sum()), "of B": int((w[8:16] < below).sum()),
            "edges": int((w[16:] < below).sum())}  # fmt: skip


def test_a_small_box_on_a_large_box_stands_on_its_four_vertices():
    w = candidates.box_box(box((1, 1, 1)), box((3, 3, 1)), body(p=(0.1, 0.2, 1.0)), body())
    assert which(w, 1e-12) == {"vertices of A": 4, "of B": 0, "edges": 0}


def test_crossed_beams_touch_at_four_crossings_of_edges():
    w = candidates.box_box(box((4, 1, 1)), box((1, 4, 1)), body(p=(0.0, 0.0, 1.0)), body())
    assert which(w, 1e-12) == {"vertices of A": 0, "of B": 0, "edges": 4}


def test_an_overhanging_box_touches_at_vertices_of_both_boxes_and_at_edge_crossings():
    """Turned by 30 degrees on a box of equal size: an octagon whose corners are crossings of edges."""
    R = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    w = candidates.box_box(box((2, 2, 1)), box((2, 2, 1)), body(R, (0.0, 0.0, 1.0)), body())
    assert which(w, 1e-12) == {"vertices of A": 0, "of B": 0, "edges": 8}
    w = candidates.box_box(box((2, 2, 1)), box((2, 2, 1)), body(p=(0.7, 0.4, 1.0)), body())
    assert which(w, 1e-12) == {"vertices of A": 1, "of B": 1, "edges": 2}


def test_crossing_edges_of_separated_boxes_have_their_distance_as_gap():
    """The edges overlap in plan, but the boxes lie one metre apart."""
    w = candidates.box_box(box((4, 1, 1)), box((1, 4, 1)), body(p=(0.0, 0.0, 2.0)), body())
    assert min(gaps(w)) == pytest.approx(1.0)


def test_a_ball_touches_faces_edges_and_corners_of_a_box():
    one = box((2, 2, 2))
    at = lambda *p: candidates.ball_box(np.array([0.0, 0.0, 0.0, 0.25]), one, body(p=p), body())[0][0]  # noqa: E731
    assert at(0.3, 0.2, 1.5) == pytest.approx(0.25)
    assert at(-1.25, 0.9, 0.0) == pytest.approx(0.0, abs=1e-15)
    assert at(1.1, -1.1, 0.0) == pytest.approx(0.1 * 2.0**0.5 - 0.25)
    assert at(1.1, -1.2, 1.2) == pytest.approx(0.3 - 0.25)
    assert at(0.9, 0.8, -0.5) == pytest.approx(-0.35)


@pytest.mark.parametrize("law", ["ball_plane", "ball_ball", "ball_box", "box_plane", "box_box"])
def test_velocities_of_contact_points_are_correct(law):
    ball, plane, cube = np.array([0.1, 0.2, 0.3, 0.25]), np.array([0.1, 0.0, 0.2, 0.6, 0.0, 0.8]), box((1, 2, 3))
    shapes = {"ball": ball, "plane": plane, "box": cube}
    first, second = (shapes[x] for x in law.split("_"))
    w_A, v_A, w_B, v_B = np.random.default_rng(8).normal(size=(4, 3))
    R_A, R_B = Rotation.random(2, random_state=4).as_matrix()
    h = 1e-6

    def at(t):
        A, B = moving(R_A, (0.2, 0.1, 2.2), w_A, v_A, t), moving(R_B, (0.0, 0.1, 0.0), w_B, v_B, t)
        return getattr(candidates, law)(first, second, A, B)

    vertices = slice(0, 16)  # the rate of two edges is that of their gap only where they touch
    for (gap, rate), (up, _), (down, _) in zip(*(x[vertices] for x in (at(0.0), at(h), at(-h))), strict=True):
        if gap != candidates.APART:
            assert (up - down) / (2 * h) == pytest.approx(rate, abs=1e-6)


def test_the_gaps_between_a_box_and_a_slope_are_those_of_the_box_vertices():
    slope = np.array([-np.sin(0.3), 0.0, np.cos(0.3)])
    heights = gaps(
        candidates.box_plane(box((2, 2, 2)), np.array([0.0, 0.0, 0.0, *slope]), body(p=(0.0, 0.0, 2.0)), body())
    )
    places = [(x, y, z + 2.0) for x, y, z in candidates.VERTICES]
    assert heights == pytest.approx([slope @ p for p in places])


def moving(R, p, w, v, t):
    """A body with constant angular velocity and constant velocity of its origin."""
    turned = Rotation.from_rotvec(np.array(w) * t).as_matrix() @ R
    return body(turned, np.array(p) + np.array(v) * t, w, v)


NUMBERS = {
    "face": np.array([0.3, -0.2, 0.5, 0.1, 0.2, 0.1, -0.3, *Rotation.random(random_state=1).as_matrix().ravel()]),
    "balls": np.array([0.3, -0.2, 0.5, 0.4, 0.1, 0.2, 0.1, 0.3, 0.0, 1.0, 0.0]),
    "edge": np.array([0.3, -0.2, 0.5, 0.1, 0.2, 0.1, -0.3, 0.6, 0.0, 0.8, 0.8, 1.0, -0.6]),
    "corner": np.array([0.3, -0.2, 0.5, 2.0, 0.2, 0.1, -0.3, *np.eye(3).ravel()]),
    "edges": np.array([0.3, -0.2, 0.5, 0.6, 0.8, 0.0, 0.1, 0.2, -0.4, 0.0, 0.28, 0.96]),
}


@pytest.mark.parametrize("kind", list(NUMBERS))
def test_contact_jacobian_rows_are_the_derivatives_of_the_gap(kind):
    """gap' = rate and rate' = wa A_A - wb B_B + bias along a motion; edges and tangents: only while they touch."""
    rng = np.random.default_rng(2)
    law, p = getattr(frames, kind), NUMBERS[kind]
    R_A, R_B = Rotation.random(2, random_state=4).as_matrix()
    w_A, v_A, w_B, v_B, p_B = rng.normal(size=(5, 3))
    f = law(p, body(R_A), body(R_B, p_B))
    p_A = -f.gap * f.F[0] if kind != "balls" else np.zeros(3)  # brought into touch

    def at(t):
        A, B = moving(R_A, p_A, w_A, v_A, t), moving(R_B, p_B, w_B, v_B, t)
        f = law(p, A, B)
        return f, frames.rows(f, A, B)

    h = 1e-5
    (f, r), (f_up, r_up), (f_down, r_down) = at(0.0), at(h), at(-h)
    if kind != "balls":
        assert f.gap == pytest.approx(0.0, abs=1e-12)
    assert (f_up.gap - f_down.gap) / (2 * h) == pytest.approx(r["rate"][0], abs=DERIVATIVE)
    assert (f_up.F - f_down.F) / (2 * h) == pytest.approx(f.dF, abs=DERIVATIVE)
    # seen from the fixed points where the origins are now
    still = [np.concatenate([np.zeros(3), -np.cross(w, v)]) for w, v in ((w_A, v_A), (w_B, v_B))]
    expected = r["wa"] @ still[0] - r["wb"] @ still[1] + r["bias"]
    change = (r_up["rate"] - r_down["rate"]) / (2 * h)
    assert change[0] == pytest.approx(expected[0], abs=DERIVATIVE)
    if kind == "face":
        assert change == pytest.approx(expected, abs=DERIVATIVE)
    assert r["wa"] @ np.concatenate([w_A, v_A]) - r["wb"] @ np.concatenate([w_B, v_B]) == pytest.approx(r["rate"])
