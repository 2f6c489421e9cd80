"""SciPy's integrators on the same compiled equations, registered beside the kernel's methods for comparison.

One adapter for all: SciPy takes the steps in Python, its dense output is copied as values at 13 nodes (exact for its
polynomials, whose degree is at most 12), and all else (guards, samples, commits) is the native code of
`native_functions`.
Where shapes could pass through each other unseen its steps are bounded as the kernel's own are (`contact.candidates`).
Steps are ten to a hundred times slower than the kernel's own.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from types import MappingProxyType, SimpleNamespace
from typing import Any

import numpy as np
from heavylift.kernel import KernelError
from heavylift.kernel.methods import METHODS, StepCode, Stepless
from heavylift.kernel.simulation.native import BREAK, EVENT, RUNNING, STILL

PEERS = {"scipy-dop853": "DOP853", "scipy-radau": "Radau", "scipy-bdf": "BDF", "scipy-lsoda": "LSODA"}
NODES = (0.5 - 0.5 * np.cos(np.pi * np.arange(13) / 12.0)).tolist()
LOOSE = 4.0  # by how much LSODA's longest step may be shorter than it could be before it begins anew


class Peer(Stepless):
    """A method whose steps SciPy takes."""

    vectors = tuple(f"n{i}" for i in range(1, len(NODES)))
    scalars = ("asked",)
    counted = MappingProxyType({"asked": 1})

    def __init__(self, name: str) -> None:
        self.name, self.solver = name, PEERS[name]

    @property
    def implicit(self) -> bool:
        return self.solver != "DOP853"

    def run(self, code: StepCode, at: Mapping[str, Any], sizes: Mapping[str, int]) -> StepCode:
        return PeerCode(code, self, at, sizes)

    def interpolate(self, s: SimpleNamespace, x: Any) -> Any:
        """Lagrange's polynomial through the nodes."""
        y: Any = 0.0
        for i, node in enumerate(NODES):
            scale, weight = 1.0, 1.0
            for j, other in enumerate(NODES):
                if j != i:
                    weight, scale = weight * (x - other), scale * (node - other)
            y = y + (weight * (1.0 / scale)) * getattr(s, f"n{i}" if i else "d0")
        return y


class PeerCode:
    """Stands in for `machine_code.Library`: `advance` and `step` here, all else in `native`."""

    def __init__(self, native: StepCode, method: Peer, at: Mapping[str, Any], sizes: Mapping[str, int]) -> None:
        self._native, self._method, self._at, self._sizes = native, method, at, sizes
        self._solver: Any = None
        self._seen = np.zeros(0), np.zeros((0, 0))  # times (13,) and tensions (13, n_ropes) of the tentative step [N]

    def call(self, name: str, *blocks: np.ndarray) -> None:
        if name == "step":
            self._step(*blocks)
        elif name == "advance":
            X, P, table = blocks
            while X[self._at["run"]] > 0.0:
                self._raise_peaks(X)
                self._native.call("commit", X, P)
                self._native.call("sampling", X, P, table)
                self._step(X, P)
                self._native.call("locating", X, P)
        else:
            if name == "commit":
                self._raise_peaks(blocks[0])
            self._native.call(name, *blocks)
            if name == "refresh":
                self._solver = None

    def _raise_peaks(self, X: np.ndarray) -> None:
        """Hills of tensions within the step that is about to count: of the highest node and its two neighbours."""
        times, tensions = self._seen
        if X[self._at["tentative"]] <= 0.0:
            return
        n = int((times <= X[self._at["t"]]).sum())
        peak, when = X[self._at["peak"]], X[self._at["peak_time"]]
        for i in range(tensions.shape[1]):
            j = int(tensions[:n, i].argmax()) if n else 0
            if 0 < j < n - 1:
                t, T = _top(times[j - 1 : j + 2].tolist(), tensions[j - 1 : j + 2, i].tolist())
                if peak[i] < T:
                    peak[i], when[i] = T, t

    def _rate(self, X: np.ndarray, P: np.ndarray, t: float, among: float, y: np.ndarray) -> dict[str, np.ndarray]:
        out = {name: np.zeros(n) for name, n in self._sizes.items()}
        self._native.call("rate", np.array([t, among]), np.ascontiguousarray(y, float), P, *out.values())
        X[self._at["asked"]] += 1.0
        return out

    def _start(self, X: np.ndarray, P: np.ndarray, t_stop: float, longest: float) -> Any:
        """A solver that begins at the present state; its piece of the profiles ends at t_stop."""
        from scipy import integrate  # 0.3 s to import

        at = self._at
        t, tol = float(X[at["t"]]), float(X[at["tol"]])
        among = t + 0.5 * min(1.0, t_stop - t)
        solver = getattr(integrate, self._method.solver)

        def slope(time: float, y: np.ndarray) -> np.ndarray:
            return self._rate(X, P, time, among, y)["dy"]

        begun = solver(slope, t, X[at["y"]].copy(), t_stop, rtol=tol, atol=tol, max_step=longest)
        begun.max_step = longest
        return begun

    def _longest(self, X: np.ndarray, P: np.ndarray, t: float, t_stop: float, y: np.ndarray) -> float:
        """Of the next step [s]."""
        longest = float(X[self._at["h_max"]])
        if "reach" in self._sizes:
            longest = min(longest, float(self._rate(X, P, t, t + 0.5 * min(1.0, t_stop - t), y)["reach"][0]))
        return longest

    def _advance(self, X: np.ndarray, P: np.ndarray, t_stop: float) -> Any:
        """One of SciPy's steps as its interpolant; raises KernelError where there is none."""
        at, solver = self._at, self._solver
        t, y = (float(X[at["t"]]), X[at["y"]].copy()) if solver is None else (solver.t, solver.y)
        longest = self._longest(X, P, t, t_stop, y)
        message: str | None = "its numbers are not finite"
        try:
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                if solver is None:
                    solver = self._start(X, P, t_stop, longest)
                elif not hasattr(solver, "h_abs") and not solver.max_step <= longest <= LOOSE * solver.max_step:
                    X[at["t"]], X[at["y"]] = t, y  # LSODA's is fixed when it begins
                    solver = self._start(X, P, t_stop, longest)
                if hasattr(solver, "h_abs"):
                    solver.max_step = longest
                    solver.atol = float(X[at["tol"]] * max(X[at["scale"]], X[at["grain"]]))  # see `small_motions`
                self._solver = solver
                message = solver.step()
        except (ValueError, ArithmeticError, np.linalg.LinAlgError):
            solver = None
        if solver is None or solver.status == "failed" or not np.isfinite(solver.y).all():
            why = (message or "its numbers are not finite").rstrip(".").lower()
            raise KernelError(f"method '{self._method.name}' gives up ({why})")
        return solver.dense_output()

    def _step(self, X: np.ndarray, P: np.ndarray) -> None:
        """One of SciPy's steps, or as many as a forced one to t_stop takes; written to X as `steps.step` does."""
        at = self._at
        before = X[at["T"]].copy()
        t0, t_stop, y0, forced = float(X[at["t"]]), float(X[at["t_stop"]]), X[at["y"]].copy(), X[at["forced"]] > 0.0
        if forced or (self._solver and self._solver.t != t0):
            self._solver = None
        pieces: list[Any] = []
        while not pieces or (forced and self._solver.status == "running"):
            pieces.append(self._advance(X, P, t_stop))
        solver = self._solver
        t, h = float(solver.t), float(solver.t) - t0
        places = [t0 + x * h for x in NODES]
        values = [next((p for p in pieces if place <= p.t), pieces[-1])(place) for place in places]
        X[at["t0"]], X[at["h0"]], X[at["f0"]], X[at["d0"]] = t0, h, X[at["f"]], y0
        for i in range(1, len(NODES)):
            X[at[f"n{i}"]] = values[i]
        X[at["t"]], X[at["y"]] = t, solver.y
        seen = [self._rate(X, P, place, place, y) for place, y in zip(places[1:-1], values[1:-1], strict=True)]
        seen.append(self._rate(X, P, t, t - 0.5 * h, solver.y))
        self._seen = np.array(places), np.array([before, *(x["T"] for x in seen)])
        for name, to in (("dy", "f"), ("T", "T"), ("G", "G")):
            X[at[to]] = seen[-1][name]
        fallen = next((i for i, x in enumerate(seen) if (x["G"] < 0.0).any()), None)
        X[at["locate"]], X[at["doubt"]], X[at["tentative"]] = float(fallen is not None), 0.0, 1.0
        if fallen is not None:
            X[at["lo"]], X[at["hi"]] = NODES[fallen], NODES[fallen + 1]
        X[at["accepted"]] += 1.0
        X[at["budget"]] -= 1.0
        calm = STILL if X[at["still"]] > 0.0 else BREAK if t >= t_stop else RUNNING
        X[at["status"]] = status = EVENT if fallen is not None and calm <= BREAK else calm
        more = X[at["budget"]] > 0.0 and X[at["rows"]] > X[at["row"]] and X[at["until"]] >= t
        X[at["calm"]], X[at["more"]] = calm, float(more)
        X[at["run"]] = float(more and status == RUNNING)
        if forced:
            self._solver = None


def _top(t: list[float], T: list[float]) -> tuple[float, float]:
    """Time and height of the parabola through three points, of which the middle one is the highest."""
    if not t[0] < t[1] < t[2]:  # a step of a few round-offs
        return t[1], T[1]
    up, down = (T[1] - T[0]) / (t[1] - t[0]), (T[2] - T[1]) / (t[2] - t[1])
    bend = (down - up) / (t[2] - t[0])
    if not bend < 0.0:
        return t[1], T[1]
    top = min(max(0.5 * (t[0] + t[1] - up / bend), t[0]), t[2])
    return top, T[0] + (top - t[0]) * (up + bend * (top - t[1]))


METHODS.update({name: lambda program, name=name: Peer(name) for name in PEERS})
