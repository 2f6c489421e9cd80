"""The native functions of one program: the code of `steps` on its memory blocks, and the loop over steps as one native
call.

Blocks: X (state of the steps), P (numbers of the scene and discrete states), M (matrices of a method), table (samples).
`advance` commits, samples, steps and locates until something has happened; the parts can be called one by one.

`Oracle` interprets the same functions on floats: NumPy instead of machine code, a thousand times slower. It checks the
tracer and the compiler: both must agree to 1e-12.
"""

from collections.abc import Callable

import numpy as np
from heavylift.kernel.compiler.emit import EmittedParts, Sequence, While, blocks as names, module
from heavylift.kernel.compiler.function import OPAQUE, Function, Layout, Primitive, flatten
from heavylift.kernel.compiler.symbol import Value
from heavylift.kernel.methods.control import Control, ErrorControl
from heavylift.kernel.methods.method import SCALARS, Method, Rate, StepState, inside
from heavylift.kernel.model.evaluation import evaluate
from heavylift.kernel.model.program import Program
from heavylift.kernel.model.tangent_stiffness import Tangent

from . import dips
from .peaks import FLAGS, POINTS, climb, slope
from .sample_row import columns, halted, kick, kicking, projection, row_layout, survey, surveying
from .steps import Row, bisect, close, commit, complete, dive, look, refresh, sample, step

OFTEN = "step", "take", "iterate"  # of the functions on whole blocks: at each stage or iteration of a step


class Stepping:
    """Native functions of a program for one integration method: steps, commits, samples and location of events."""

    def __init__(self, program: Program, method: Method, control: Control) -> None:
        p = self.program = program
        self.method, self.control = method, control
        nq, nv = p.nq, p.nv
        n_ropes, n_guards = len(p.system.straight_ropes), len(p.guards)
        climbs = n_ropes > 0 and method.native
        states = dict.fromkeys(("y", "f", "f0", "d0", *method.vectors), p.ny)
        ropes = dict.fromkeys(("T", "peak", "peak_time", *(POINTS if climbs else ())), n_ropes)
        other = ["coarse"] if method.completes else []
        blind = p.contacts.bounded and not isinstance(control, ErrorControl)
        other += ["passing"] if blind else []
        other += FLAGS if climbs else []
        dipping = n_guards > 0 and method.native
        other += dips.FLAG if dipping else []
        scalars = dict.fromkeys([*SCALARS, *method.scalars, *other])
        rows = dict.fromkeys(("gap", "slip", "pivot"), len(p.constraints))
        pushed = rows["gap"] if p.contacts.sites else 0
        surveyed = {"delassus": pushed * pushed, "speed": pushed, "free": pushed, "impulse": pushed}
        sizes = {
            **scalars,
            **states,
            **ropes,
            "G": n_guards,
            **dict.fromkeys(dips.ENDS if dipping else (), n_guards),
            **rows,
            **(surveyed if pushed else {}),
        }
        self.layout = Layout(sizes, frozenset(states))
        self.plain = Layout(sizes)
        n_p = len(p.parameters.initial)
        self.row_layout = row_layout(p)
        self.columns = self.row_layout.size

        chosen = isinstance(control, ErrorControl) and method.native  # lengths of steps
        bounded = isinstance(control, ErrorControl) and p.contacts.bounded
        extra = {"reach": bounded, "window": blind, "drift": chosen and rows["gap"]}
        asked = [name for name, there in extra.items() if there]
        self.rate_sizes = {"dy": p.ny, "T": n_ropes, "G": n_guards, **dict.fromkeys(asked, 1)}

        def rate(t: Value, y: Value, P: Value) -> dict[str, Value]:
            x = evaluate(p, t[0], y, P, t[1])
            return {"dy": x.dy, "T": x.pulls, "G": x.guards, **{name: [getattr(x, name)] for name in asked}}

        def take(s: StepState, rate: Rate, row: Row) -> None:
            step(s, rate, method, control)

        state = {"t": 1, "y": p.ny, "P": n_p}
        self.f_rate = Function("rate", rate, {**state, "t": 2}, vectors=["dy"])
        self.f_project = projection(p) if rows["gap"] else None

        def row(t: Value, y: Value, P: Value) -> dict[str, Value]:
            at = self.f_project(t=t, y=y, P=P).place if self.f_project else y
            return {"values": columns(evaluate(p, t[0], at, P))}

        self.f_row = Function("row", row, state, ["values"], rare=True)
        matrices = bool(method.matrices)
        self.functions: dict[str, Function | EmittedParts] = {
            "step": self._on_block("step", take, matrices=matrices),
            "bisect": self._on_block("bisect", lambda s, rate, row: bisect(s, rate, method)),
            "commit": self._projecting(
                "commit", lambda s, project: commit(s, p.quaternions, slice(nq, nq + nv), project)
            ),
            "sample": self._on_block(
                "sample", lambda s, rate, row: sample(s, rate, row, method), table=True, matrices=matrices
            ),
            "refresh": self._on_block("refresh", lambda s, rate, row: refresh(s, rate, method)),
            "look": self._on_block("look", lambda s, rate, row: look(s, row), table=True),
        }
        if self.f_project:
            self.functions["close"] = self._projecting("close", close)
        if pushed:
            rows_of, kicked = surveying(p), kicking(p)
            self.functions["survey"] = self._plain("survey", lambda s, P: survey(s, P, rows_of, inside(s)))
            self.functions["kick"] = self._plain("kick", lambda s, P: kick(s, P, kicked))
        self.functions["rate"] = self.f_rate
        abreast = max([1, *(k.v.stop - k.v.start for k in p.graph.links)])
        free = tuple(tree.v.start + k for tree, _ in p.instances for k in tree.free_dofs)
        self.tangent = Tangent(nq, nv, free, tuple(p.quaternions), abreast, self.rate_sizes)
        self.functions |= {f.name: f for f in self.tangent.functions(self.f_rate)}
        at, f = self.layout.at, self.functions
        if p.locked:
            f["halt"] = self._halt(n_p)
        if prologue := method.prologue(self._on_method, at, self.f_rate, self.rate_sizes):
            f["step"] = Sequence("step", (*prologue, self._on_block("take", take, matrices=matrices)))
        ready: tuple[While, ...] = ()
        if method.completes:
            f["complete"] = self._on_block("complete", lambda s, rate, row: complete(s, rate, method))
            ready = (While("completing", at["coarse"], (f["complete"],)),)
        peaks: tuple[Function | EmittedParts, ...] = ()
        if climbs:
            f["slope"] = self._on_block("slope", lambda s, rate, row: slope(s, rate))
            f["climb"] = self._on_block("climb", lambda s, rate, row: climb(s, rate, method))
            f["climbing"] = While("climbing", at["hilly"], (*ready, f["climb"]))
            peaks = While("sloping", at["steep"], (f["slope"],)), f["climbing"]
        sampling = While("sampling", at["due"], (*ready, f["sample"]))
        locating = While("locating", at["locate"], (*ready, f["bisect"]))
        searching: tuple[While, ...] = ()
        if dipping:
            f["dive"] = self._on_block("dive", lambda s, rate, row: dive(s, rate, method))
            searching = (While("diving", at["dip"], (*ready, f["dive"])),)
        observers = *searching, locating
        self.advance: EmittedParts = While("advance", at["run"], (f["commit"], *peaks, sampling, f["step"], *observers))
        if not method.native:
            del f["step"]
            f |= {"sampling": sampling, "locating": locating}
            self.advance = Sequence("advance", ())

    def ir(self, fused: bool = False) -> str:
        """Return the LLVM IR of all functions; `fused`: use fused multiply-adds."""
        return module(self.advance, *self.functions.values(), fused=fused)

    def _halt(self, n_p: int) -> Function:
        """Return a function that stops locked joints at once."""
        p = self.program
        blocks = {"t": 1, "y": p.ny, "P": n_p}
        at_once = Function("halted", lambda t, y, P: {"after": halted(evaluate(p, t[0], y, P))}, blocks, ["after"])

        def body(X: Value, P: Value) -> dict[str, Value]:
            s = self.layout.unpack(X, StepState)
            s.y = at_once(t=[s.t], y=s.y, P=P).after
            return {"X": self.layout.pack(s)}

        return Function("halt", body, {"X": self.layout.size, "P": OPAQUE}, rare=True)

    def _projecting(self, name: str, part: Callable[..., None]) -> Function:
        """Return a native function of the blocks X (scalars) and P that runs `part(s, project)`; `project` may be
        None."""
        f = self.f_project
        return self._plain(name, lambda s, P: part(s, (lambda t, y: f(t=[t], y=y, P=P)) if f else None))

    def _plain(self, name: str, part: Callable[..., None]) -> Function:
        """Return a native function of the blocks X (in scalars) and P that runs `part(s, P)`."""

        def body(X: Value, P: Value) -> dict[str, Value]:
            s = self.plain.unpack(X, StepState)
            part(s, P)
            return {"X": self.plain.pack(s)}

        return Function(name, body, {"X": self.plain.size, "P": OPAQUE}, rare=True)

    def _on_method(
        self, name: str, part: Callable[..., Value], matrices: bool = False, plain: bool = False
    ) -> Function:
        """Return a native function that runs a part of the method, `part(s, rate)`. If `plain`, X is in scalars."""
        return self._on_block(name, lambda s, rate, row: part(s, rate), matrices=matrices, plain=plain)

    def _on_block(
        self, name: str, part: Callable[..., Value], table: bool = False, matrices: bool = False, plain: bool = False
    ) -> Function:
        """Return a native function of the blocks X and P (and M, and the table) that runs `part(s, rate, row)`. `part`
        returns the row for the table, or the new contents of M."""
        layout = self.plain if plain else self.layout

        def body(X: Value, P: Value, M: Value = None) -> dict[str, Value]:
            s = layout.unpack(X, StepState)
            s.M, s.P = M, P
            r = part(
                s,
                lambda t, among, y: self.f_rate(t=[t, among], y=y, P=P),
                lambda t, y: flatten(self.f_row(t=[t], y=y, P=P).values),
            )
            written = {"table" if table else "M": r} if table or r is not None else {}
            return {"X": layout.pack(s), **written}

        inputs = {"X": layout.size, "P": len(self.program.parameters.initial) if plain else OPAQUE}
        return Function(name, body, inputs | ({"M": OPAQUE} if matrices else {}), rare=name not in OFTEN)


class Oracle:
    """Interpreter of the native functions on Python floats, a reference for tests of the compiled `emit.Library`."""

    def __init__(self, method: Stepping) -> None:
        self._functions: dict[str, Function | EmittedParts] = {**method.functions, "advance": method.advance}

    def call(self, name: str, *blocks: np.ndarray) -> None:
        """Run a native function on its blocks, in the order of its native arguments, by interpreting its operations."""
        f = self._functions[name]
        self._run(f, dict(zip(names(f), blocks, strict=True)))

    def _run(self, f: Function | EmittedParts, memory: dict[str, np.ndarray]) -> None:
        if isinstance(f, While):
            while memory[f.block][f.flag] > 0.0:
                for part in f.parts:
                    self._run(part, memory)
        elif isinstance(f, EmittedParts):
            for part in f.parts:
                self._run(part, memory)
        elif isinstance(f, Primitive):
            f.body(**{k: memory[k] for k in f.inputs})
        else:
            out = f.body(**{k: memory[k] if k == "M" else memory[k].copy() for k in f.inputs})
            for name, values in out.items():
                row, given = values if isinstance(values, tuple) else (0.0, values)
                numbers = [float(x) for x in flatten(given)]
                start = int(row) * len(numbers)
                memory[name].reshape(-1)[start : start + len(numbers)] = numbers
