"""Strict IEEE arithmetic: optimisation levels, instruction sets and batched calls change no bit."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest
from every_law import yard
from heavylift.kernel.algebra import cos, power, sin
from heavylift.kernel.compiler import Function, Library, SimdBatch, arranged, module
from heavylift.kernel.description import Body, InputSignal, Joint, Point, Reeving, Sheave, System
from heavylift.kernel.simulation import Simulation

PROCESSORS = {"x86-64": "sse2", "x86-64-v2": "sse4.2", "haswell": "avx2", "skylake-avx512": "avx512f"}
HAS = llvm.get_host_cpu_features()
TESTS = Path(__file__).parents[2]
SCRIPT, STORED = TESTS / "determinism" / "digests.py", TESTS / "data" / "digests.json"
FEW = ["lift", "linkage"]  # a block on ropes and supports; joints that close a loop
PLAIN = {"OPENBLAS_CORETYPE": "Prescott", "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4"}  # libraries without AVX
KERNELS = {"Prescott": "sse2", "Haswell": "avx2", "SkylakeX": "avx512f"}  # of OpenBLAS, which sum in other orders


def digest(s: Simulation, code: Library) -> str:
    """Of a tenth of a second: events, steps, samples."""
    s.native.code = code
    s.start()
    s.run(100_000_000)
    s.interrupt(100_000_001)
    s.settle()
    return hashlib.sha256(s.X.tobytes() + b"".join(row.tobytes() for _, row in s.rows)).hexdigest()


@pytest.mark.large
def test_optimisation_levels_and_instruction_sets_give_bit_identical_results():
    def run(opt, cpu):
        s = Simulation(yard(), 1e-8, 20_000_000)
        return digest(s, Library(s.native.structure, s.method.ir, opt, cpu=cpu))

    want = run(1, None)
    for opt in (0, 2, 3):
        assert run(opt, None) == want, f"level {opt}"
    for cpu, feature in PROCESSORS.items():
        if HAS.get(feature):
            assert run(1, cpu) == want, cpu


@pytest.mark.parametrize("environment", [PLAIN, {}], ids=["plain libraries", "own libraries"])
@pytest.mark.parametrize("cpu", PROCESSORS)
@pytest.mark.large(beyond=1)
def test_results_of_the_kernel_in_reference_cases_have_their_stored_digests(cpu, environment, request):
    """Of whole runs of bundled scenes, a few or, with --full, all of them."""
    if not HAS.get(PROCESSORS[cpu]):
        pytest.skip(f"this processor is no {cpu}")
    stored = json.loads(STORED.read_text())
    names = sorted(stored) if request.config.getoption("full") else FEW
    command = [sys.executable, SCRIPT, *names, "--processor", cpu]
    out = subprocess.run(command, env={**os.environ, **environment}, check=True, capture_output=True, text=True).stdout
    assert json.loads(out) == {name: stored[name] for name in names}


def attitude(random):
    """Any rotation, by operations on its elements."""
    x, y, z, w = (float(e) for e in random.normal(size=4))
    n = x * x + y * y + z * z + w * w
    rows = (w * w + x * x - y * y - z * z, 2 * (x * y - z * w), 2 * (x * z + y * w)), (
        2 * (x * y + z * w), w * w - x * x + y * y - z * z, 2 * (y * z - x * w)), (
        2 * (x * z - y * w), 2 * (y * z + x * w), w * w - x * x - y * y + z * z)  # fmt: skip
    return tuple(tuple(e / n for e in row) for row in rows)


def turned_tackle(seed):
    """A rope over two sheaves on a body that a joint holds, all of them at any attitude."""
    random = np.random.default_rng(seed)
    block = Body("block", 900.0, inertia=((40.0, 0.0, 0.0), (0.0, 50.0, 0.0), (0.0, 0.0, 60.0)))
    turned = {"R_PJ": attitude(random), "R_CJ": attitude(random), "q0": (random.normal(),)}
    axis, across, down = (np.array(e) for e in attitude(random))
    sheaves = [Sheave(Point("block", tuple(k * across)), axis=tuple(axis), radius=0.2, friction=0.1) for k in (-1, 1)]
    ends = [Point("block", tuple(k * across + random.uniform(0.5, 2.0) * down)) for k in (-3, 3)]
    rope = Reeving("rope", ends[0], tuple(sheaves), ends[1], 1e6, InputSignal(8.0), 1e3)
    return System((block,), (Joint("held", "revolute", "world", "block", **turned),), forces=(rope,))


def numbers_of_laws():
    """Digest of the parameters with which thirty such ropes begin."""
    found = [Simulation(turned_tackle(seed), 1e-6, 20_000_000).native.P for seed in range(30)]
    return hashlib.sha256(np.concatenate(found).tobytes()).hexdigest()


def test_constants_of_force_laws_do_not_depend_on_the_math_library():
    """Places at the start come from chains of rotations, which a library would sum in its own order."""
    here = Path(__file__)
    folders = [str(here.parent), str(here.parents[1])]
    code = f"import sys; sys.path[:0] = {folders!r}; from {here.stem} import numbers_of_laws; "
    for kernel, feature in KERNELS.items():
        if HAS.get(feature):
            command = [sys.executable, "-c", code + "print(numbers_of_laws())"]
            environment = {**os.environ, "OPENBLAS_CORETYPE": kernel}
            out = subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout
            assert out.strip() == numbers_of_laws(), kernel


def small(k):
    """Another function of two numbers, whose result depends on everything in it."""
    return Function(
        f"f{k}",
        lambda x, p: {"y": [sin(x[0]) * p[0] + cos(x[1]) * (k + 0.3), power(abs(x[0]) + 0.5, 0.3)]},
        {"x": 2, "p": 1},
    )


def many(n):
    """n calls of one function, then n of another on their results in another order, then a chain of n calls."""
    f, g = small(0), small(1)

    def body(x, p):
        first = [f(x=x[2 * i : 2 * i + 2], p=[p[i]]).y for i in range(n)]
        second = [g(x=[first[(i + 1) % n][0], first[i][1]], p=[2.5]).y for i in range(n)]
        for _ in range(3):
            second[0] = g(x=second[0], p=[1.5]).y
        return {"y": np.concatenate(second)}

    return Function("many", body, {"x": 2 * n, "p": n})


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 9, 20])
def test_concurrent_and_separate_simulations_give_bit_identical_results(n):
    f = many(n)
    random = np.random.default_rng(n)
    x, p, y = random.normal(size=2 * n), random.normal(size=n), np.zeros(2 * n)
    Library("many", lambda: module(f), cache=False).call("many", x, p, y)
    assert y.tolist() == [float(e) for e in f.body(x=x.tolist(), p=p.tolist())["y"]]
    batches = [b for b in arranged(f.nodes) if isinstance(b, SimdBatch)]
    assert sum(len(b.calls) for b in batches) == (2 * n if n > 1 else 0), "the chain stays a chain"


def test_a_value_shared_by_all_simd_lanes_of_native_code_is_passed_once():
    """A block that is the same in all calls, and calls inside that hand it on."""
    inner = Function("inner", lambda p, x: {"y": [p[0] * x[0] + p[1]]}, {"p": 2, "x": 1})
    outer = Function("outer", lambda p, x: {"y": [inner(p=p, x=[sin(x[0])]).y[0] * p[1]]}, {"p": 2, "x": 1})

    def body(p, x):
        alike = [outer(p=p, x=[e]).y[0] for e in x]
        other = [outer(p=[p[0], e], x=[e]).y[0] for e in x]
        return {"y": [*alike, *other]}

    f = Function("sharing", body, {"p": 2, "x": 6})
    p, x, y = np.array([0.7, -1.3]), np.linspace(-2.0, 3.0, 6), np.zeros(12)
    Library("sharing", lambda: module(f), cache=False).call("sharing", p, x, y)
    assert y.tolist() == [float(e) for e in body(p.tolist(), x.tolist())["y"]]


def test_function_calls_that_depend_on_each_other_are_not_vectorised_together():
    f, g = small(0), small(1)

    def body(x):
        a = f(x=x[:2], p=[1.0]).y
        b = g(x=a, p=[1.0]).y
        c = g(x=x[2:], p=[1.0]).y
        d = f(x=c, p=[1.0]).y
        return {"y": [*b, *d]}

    h = Function("crosswise", body, {"x": 4})
    x, y = np.array([0.3, -0.8, 1.7, 0.2]), np.zeros(4)
    Library("crosswise", lambda: module(h), cache=False).call("crosswise", x, y)
    assert y.tolist() == [float(e) for e in body(x.tolist())["y"]]
