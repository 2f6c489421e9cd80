"""sin, cos, atan2, exp, log, power against 60 digits of decimal arithmetic; machine code against floats, bitwise."""

from decimal import Decimal, localcontext
from math import inf, ldexp, nextafter, pi, ulp
from random import Random

import numpy as np
import pytest
from heavylift.kernel.algebra import atan2, cos, exp, log, power, sin
from heavylift.kernel.compiler import Function, Library, module

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")
RANGE = 1.6e6  # [rad] up to which an angle loses nothing
NUMBERS = 1500  # per case


def sine(x: Decimal) -> Decimal:
    """By the Taylor series, after whole half turns; to an absolute 1e-50."""
    n = (x / PI).to_integral_value()
    r = x - n * PI
    term = total = r
    k = 1
    while abs(term) > Decimal("1e-50"):
        term *= -r * r / (2 * k * (2 * k + 1))
        total += term
        k += 1
    return total if n % 2 == 0 else -total


def cosine(x: Decimal) -> Decimal:
    return sine(x + PI / 2)


def angle(y: float, x: float) -> Decimal:
    """One Newton step from the angle that is tested: its error, some 1e-16, enters with the third power."""
    a = Decimal(atan2(y, x))
    s, c, X, Y = sine(a), cosine(a), Decimal(x), Decimal(y)
    return a + (Y * c - X * s) / (X * c + Y * s)


def root(x: float, p: float) -> Decimal:
    return (Decimal(x).ln() * Decimal(p)).exp()


def angles() -> list[float]:
    """Uniform, of all sizes, and the doubles around multiples of pi/4, where the result is smallest or changes form."""
    random = Random(1)
    out = [random.uniform(-7.0, 7.0) for _ in range(NUMBERS)]
    out += [random.uniform(-RANGE, RANGE) for _ in range(NUMBERS)]
    out += [
        random.choice((-1.0, 1.0)) * ldexp(random.uniform(1.0, 2.0), random.randint(-60, 19)) for _ in range(NUMBERS)
    ]
    for n in [*range(40), *(random.randint(40, 2_000_000) for _ in range(NUMBERS // 6))]:
        x = n * pi / 4.0
        out += [x, nextafter(x, inf), nextafter(x, -inf)]
    return out


def vectors() -> list[tuple[float, float]]:
    random = Random(2)
    out = [(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)) for _ in range(NUMBERS)]
    for t in (2.0**-30, 0.4375, 0.5, 0.6875, 1.0, 1.0 / 0.6875, 2.0, 1.0 / 0.4375, 2.0**30):
        for _ in range(60):
            x = random.choice((-1.0, 1.0)) * random.uniform(0.5, 2.0)
            y = random.choice((-1.0, 1.0)) * x * t * (1.0 + random.choice((0.0, 1e-16, -1e-16, 1e-9, -1e-9)))
            out.append((y, x))
    return out


def bases() -> list[tuple[float, float]]:
    """Those of the step control, numbers around one, and all sizes."""
    random = Random(3)
    out = [
        (ldexp(random.uniform(1.0, 2.0), random.randint(-34, 60)), p) for p in (-0.2, -0.14, 0.04) for _ in range(300)
    ]
    out += [
        (1.0 + random.uniform(-1.0, 1.0) * 10.0 ** -random.randint(0, 15), random.uniform(-1, 1)) for _ in range(600)
    ]
    out += [(ldexp(random.uniform(1.0, 2.0), random.randint(-90, 90)), random.uniform(-1.0, 1.0)) for _ in range(600)]
    return out


def worst(got: list[float], want: list[Decimal]) -> float:
    """Largest error in units of the last place of the result."""
    return max(float(abs(Decimal(g) - w)) / ulp(float(w)) for g, w in zip(got, want, strict=True))


@pytest.mark.parametrize(
    ("f", "exact", "arguments"),
    [
        (sin, lambda x: sine(Decimal(x)), [(x,) for x in angles()]),
        (cos, lambda x: cosine(Decimal(x)), [(x,) for x in angles()]),
        (atan2, angle, vectors()),
        (power, root, bases()),
        (exp, lambda x: Decimal(x).exp(), [(x / 10.0,) for x in angles() if abs(x) < 6000.0]),
        (log, lambda x: Decimal(x).ln(), [(x,) for x, _ in bases() if x != 1.0]),
    ],
    ids=["sin", "cos", "atan2", "power", "exp", "log"],
)
def test_elementary_functions_are_within_one_unit_of_the_last_place(f, exact, arguments):
    with localcontext(prec=70):
        want = [exact(*a) for a in arguments]
    error = worst([f(*a) for a in arguments], want)
    print(f"{error:.3f} ulp")
    assert 0.4 < error < 1.0, "at least the last rounding, at most one unit"


def test_elementary_functions_of_the_kernel_return_known_exact_values():
    assert [sin(0.0), cos(0.0), atan2(0.0, 0.0), atan2(0.0, 2.0), power(1.0, 0.3)] == [0.0, 1.0, 0.0, 0.0, 1.0]
    assert [atan2(1.0, 0.0), atan2(-1.0, 0.0), atan2(0.0, -1.0)] == [pi / 2, -pi / 2, pi]
    assert [power(2.0**40, 0.5), power(2.0**-40, 0.25), power(8.0, 1.0)] == [2.0**20, 2.0**-10, 8.0]
    assert power(inf, -0.2) > 0.0, "a step that failed without a number is followed by a shorter one"


def test_sines_and_cosines_of_very_large_angles_are_within_two_units_of_the_last_place():
    random = Random(4)
    for _ in range(300):
        x = ldexp(random.uniform(1.0, 2.0), random.randint(21, 48))
        with localcontext(prec=70):
            assert abs(Decimal(sin(x)) - sine(Decimal(x))) < Decimal(2.0 * ulp(x))


@pytest.mark.parametrize("opt", [0, 1, 2, 3])
def test_elementary_functions_have_the_same_bits_in_machine_code(opt):
    f = Function(
        "f",
        lambda x: {"y": [sin(x[0]), cos(x[0]), atan2(x[1], x[2]), power(x[3], x[4]), log(x[3]), exp(x[4])]},
        {"x": 5},
    )
    code = Library("elementary", lambda: module(f), opt, cache=False)
    for a, v, b in zip(angles(), vectors() * 4, bases() * 4, strict=False):
        x, y = np.array([a, *v, *b]), np.zeros(6)
        code.call("f", x, y)
        assert y.tolist() == [sin(a), cos(a), atan2(*v), power(*b), log(b[0]), exp(b[1])]
