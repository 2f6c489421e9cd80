"""The force table, which assigns a law to every kind of force: a new force is a new entry here and its dataclass in
`forces.py`.

`shared` turns the laws of a scene into traced functions, one per shape, that evaluation calls for each law with its
own numbers, ends, signal and joint.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from heavylift.kernel.compiler.function import Function, Outputs
from heavylift.kernel.compiler.symbol import Array, Scalars
from heavylift.kernel.description import forces as kinds
from heavylift.kernel.description.forces import Force, InputSignal, wrong_wave
from heavylift.kernel.description.mechanics import Brake, JointSpring, Law, Rope, Stop, Support, System
from heavylift.kernel.description.units import wrong_sign

from .force_law import BODY, ForceLaw, LawOutput, SampledQuantity, Setting
from .joint_laws import BrakeLaw, JointSpringLaw, StopLaw, SupportLaw
from .loads import CharacteristicLaw, ImmersionLaw, LoadLaw, WindLaw
from .mooring import MooringLaw
from .radiation import RadiationLaw
from .reeving import ReevingLaw
from .ropes import RopeLaw
from .springs import BushingLaw, SpringLaw, TorsionLaw
from .streams import StreamLaw
from .tugger import TuggerLaw
from .user_laws import UserLawEntry

LISTS = ("guards", "shown", "turned", "turning")

FORCES: dict[type, ForceLaw[Any]] = {
    Rope: RopeLaw(),
    Support: SupportLaw(),
    JointSpring: JointSpringLaw(),
    Stop: StopLaw(),
    Brake: BrakeLaw(),
    kinds.Load: LoadLaw(),
    kinds.Wind: WindLaw(),
    kinds.Stream: StreamLaw(),
    kinds.Spring: SpringLaw(),
    kinds.Torsion: TorsionLaw(),
    kinds.Bushing: BushingLaw(),
    kinds.Radiation: RadiationLaw(),
    kinds.Characteristic: CharacteristicLaw(),
    kinds.Immersion: ImmersionLaw(),
    kinds.UserLaw: UserLawEntry(),
    kinds.Reeving: ReevingLaw(),
    kinds.MooringLine: MooringLaw(),
    kinds.TuggerLine: TuggerLaw(),
}


def law_of(f: Law) -> ForceLaw[Any]:
    """Return the law of a force from the force table."""
    return FORCES[type(f)]


@dataclass(frozen=True)
class SharedForce:
    """A force of a scene with the traced function that forces of equal shape share."""

    force: Any
    law: ForceLaw[Any]
    ends: tuple[int, ...]  # link numbers of its bodies, -1 for the ground
    along: tuple[int, int] | None  # indices of its coordinate in q and v
    numbers: list[float]
    signal: InputSignal | None
    guards: tuple[str, ...]  # names
    shows: tuple[SampledQuantity, ...]
    angles: int
    function: Function
    key: str

    @property
    def name(self) -> str:
        return str(self.force.name)

    @property
    def structure(self) -> tuple[object, ...]:
        """Key that is equal for forces which can share machine code: same law, bodies, joint and kind of signal."""
        s = self.signal
        return self.key, self.ends, self.along, s and (s.driven, bool(s.times), s.wave is not None, s.waves is not None)


def shared(laws: tuple[Law, ...], setting: Setting) -> tuple[SharedForce, ...]:
    """Return all forces of a scene with their laws; laws of equal shape share one traced function."""
    graph, poses = setting.graph, setting.poses
    functions: dict[str, Function] = {}
    out = []
    for f in laws:
        law = law_of(f).within(f, setting)
        numbers = [float(x) for x in law.numbers(f, poses)]
        key = repr((type(f).__name__, law.shape(f), len(numbers), len(f.points), bool(f.along)))
        if key not in functions:
            functions[key] = _function(f"force{len(functions)}", f, law, len(numbers))
        out.append(
            SharedForce(
                f,
                law,
                tuple(graph.number(e.body) for e in f.points),
                graph.coordinate(f.name, *f.along) if f.along else None,
                numbers,
                law.signal(f),
                law.guards(f),
                tuple(SampledQuantity(*x) for x in law.shows(f)),
                law.angles(f),
                functions[key],
                key,
            )
        )
    return tuple(out)


def steered(system: System) -> list[str]:
    """Return the names of the forces whose signals a command can set at once; ropes over sheaves are not among them."""
    ropes = {r.name for r in system.reevings}
    return [name for name, signal in signals(system.forces).items() if signal.driven and name not in ropes]


def signals(forces: tuple[Force, ...]) -> dict[str, InputSignal]:
    """Return, by the names of the forces, the signals of those forces that have one."""
    return {f.name: s for f in forces if (s := law_of(f).signal(f))}


def check_force(f: Law) -> None:
    """Raise KernelError for an invalid force."""
    law = law_of(f)
    field, message = wrong_sign(f)
    law.demand(f, field, not field, message)
    law.check(f)
    s = law.signal(f)
    if s:
        fault = wrong_wave(s.wave, s.waves)
        law.demand(f, "signal", not fault, fault)
    if s and (s.times or s.values):
        n, m = len(s.times), len(s.values)
        law.demand(f, "signal", n == m, f"has {n} times and {m} values; give one value for each time")
        late = next((b for a, b in pairwise(s.times) if b < a), None)
        law.demand(f, "signal", late is None, f"goes back to {late} s; its times must not fall")
        law.demand(f, "signal", not s.driven, "has a history and is driven; it can only be one of them")


def _function(name: str, f: Law, law: ForceLaw[Any], numbers: int) -> Function:
    ends = [f"e{i}" for i in range(len(f.points))]
    blocks = {"p": numbers, **dict.fromkeys(ends, BODY)}
    blocks |= {"s": 2} if law.signal(f) else {}
    blocks |= {"x": 2} if f.along else {}
    blocks |= {"t": 1} if law.timed else {}
    n = law.angles(f)
    blocks |= {"c": n} if n else {}

    def body(
        p: Array, s: Scalars = (), x: Scalars = (), t: Scalars = (0.0,), c: Scalars = (), **bodies: Array
    ) -> Outputs:
        counted = {"counted": c} if n else {}
        a: LawOutput = law.answer(f, p, [bodies[e] for e in ends], s, x, t[0], **counted)
        one = {k: [getattr(a, k)] for k in ("effort", "heat", "work", "stored")}
        return {**one, **{k: getattr(a, k) for k in LISTS}, **{f"w{i}": w for i, w in enumerate(a.wrenches)}}

    return Function(name, body, blocks)
