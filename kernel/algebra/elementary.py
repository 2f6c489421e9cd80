"""sin, cos, atan2, exp, log and powers from additions, multiplications and divisions alone: independent of libm.

The functions run on floats and on symbols, so machine code, its reference on floats and commands agree to the last bit,
on every processor and at every optimisation level. On floats they need no NumPy, so planning, level selection and
messages use them, too. At most 1 ulp of error (the tests compare with 40 digits): sin and cos up to |x| = 1.6e6 rad
(2.6e5 turns), beyond that 1 ulp of the argument is lost; atan2 for coordinates between 2^-300 and 2^300; power(x, p)
for x > 0, |p| <= 1, and for as large p as |p log x| <= 64. Sources: argument reduction after Cody and Waite in the form
of fdlibm's `e_rem_pio2.c`, kernels `k_sin.c`, `k_cos.c`, `s_atan.c`, `e_exp.c` (Sun Microsystems 1993); error-free sums
and products: Dekker 1971, Knuth 4.2.2.
"""

from functools import cache
from math import pi
from typing import TYPE_CHECKING, Any

from heavylift.kernel.compiler.symbol import (
    Scalar,
    Scalars,
    exponent,
    is_sym,
    maximum,
    minimum,
    node,
    power_of_two,
    printing,
    select,
)

if TYPE_CHECKING:
    from heavylift.kernel.compiler.function import Function, Outputs

Pair = tuple[Scalar, Scalar]  # an unevaluated sum: a value and what its rounding left over

_ROUND = 1.5 * 2.0**52  # x + _ROUND - _ROUND is the whole number nearest to x
_SPLIT = 2.0**27 + 1.0
# pi/2 in three pieces of 33 bits, whose products with whole numbers below 2^20 are exact, and the rest
_HALF_PI = tuple(
    map(float.fromhex, ("0x1.921fb544p+0", "0x1.0b4611a6p-34", "0x1.3198a2ep-69", "0x1.b839a252049c1p-104"))
)
_SIN = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04, 2.75573137070700676789e-06,
    -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
_COS = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05, -2.75573143513906633035e-07,
    2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
_ATAN = (
    3.33333333333329318027e-01, -1.99999999998764832476e-01, 1.42857142725034663711e-01, -1.11111104054623557880e-01,
    9.09088713343650656196e-02, -7.69187620504482999495e-02, 6.66107313738753120669e-02, -5.83357013379057348645e-02,
    4.97687799461593236017e-02, -3.65315727442169155270e-02, 1.62858201153657823623e-02,
)  # fmt: skip
_ATAN_HALF: Pair = (4.63647609000806093515e-01, 2.26987774529616870924e-17)
_ATAN_ONE: Pair = (7.85398163397448278999e-01, 3.06161699786838301793e-17)
_QUARTER: Pair = (1.57079632679489655800e00, 6.12323399573676603587e-17)
_LN2: Pair = (6.93147180369123816490e-01, 1.90821492927058770002e-10)  # 32 bits and the rest
_EXP = (
    1.66666666666666019037e-01, -2.77777777770155933842e-03, 6.61375632143793436117e-05, -1.65339022054652515390e-06,
    4.13813679705723846039e-08,
)  # fmt: skip
_THIRD: Pair = (1.0 / 3.0, 1.850371707708594e-17)
_ATANH = tuple(1.0 / (2 * k + 1) for k in range(2, 13))  # of log m = 2 atanh((m - 1)/(m + 1)), behind 1 + f^2/3


def _sum(a: Scalar, b: Scalar) -> Pair:
    """Return a + b, rounded, and the rounding error."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


def _product(a: Scalar, b: Scalar) -> Pair:
    """Return a b, rounded, and the rounding error."""
    p, x, y = a * b, _SPLIT * a, _SPLIT * b
    ah, bh = x - (x - a), y - (y - b)
    al, bl = a - ah, b - bh
    return p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)


def _times(a: Pair, b: Pair) -> Pair:
    p, e = _product(a[0], b[0])
    return _sum(p, e + (a[0] * b[1] + a[1] * b[0]))


def _ratio(a: Pair, b: Pair) -> Pair:
    x = a[0] / b[0]
    p, e = _product(x, b[0])
    return x, (((a[0] - p) - e) + a[1] - x * b[1]) / b[0]


def _polynomial(c: tuple[float, ...], x: Scalar) -> Scalar:
    """Return c[0] + c[1] x + ... by Horner's rule."""
    y: Scalar = c[-1]
    for a in c[-2::-1]:
        y = a + x * y
    return y


def nearest(x: Scalar) -> Scalar:
    """Return the integer nearest to x, for |x| up to 2^51; ties are rounded to the even integer."""
    return x + _ROUND - _ROUND


# ---- sine and cosine -----------------------------------------------------------------------------------------


def _reduced(x: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """Return x - n pi/2 as a pair within +-pi/4, and n modulo 4 as -2 ... 2."""
    n = nearest(x * (2.0 / pi))
    r, e1 = _sum(x - n * _HALF_PI[0], -(n * _HALF_PI[1]))
    r, e2 = _sum(r, -(n * _HALF_PI[2]))
    low = (e1 + e2) - n * _HALF_PI[3]
    y = r + low
    return y, (r - y) + low, n - 4.0 * nearest(0.25 * n)


def _kernels(y: Scalar, low: Scalar) -> Pair:
    """Return sin and cos of an argument within +-pi/4."""
    z = y * y
    w = z * z
    v = z * y
    r = _SIN[1] + z * (_SIN[2] + z * _SIN[3]) + z * w * (_SIN[4] + z * _SIN[5])
    sine = y - ((z * (0.5 * low - v * r) - low) - v * _SIN[0])
    r = z * (_COS[0] + z * (_COS[1] + z * _COS[2])) + w * w * (_COS[3] + z * (_COS[4] + z * _COS[5]))
    half = 0.5 * z
    one = 1.0 - half
    return sine, one + (((1.0 - one) - half) + (z * r - y * low))


def sin(x: Scalar) -> Any:
    """Return the sine of x [rad]."""
    if printing(x):
        return node("sin", x)
    y, low, m = _reduced(x)
    sine, cosine = _kernels(y, low)
    even = 1.0 - abs(m)  # 1, 0, -1 for m = 0, +-1, +-2; traced code computes the rest only once for sine and cosine
    return select(abs(even) > 0.0, even * sine, m * cosine)


def cos(x: Scalar) -> Any:
    """Return the cosine of x [rad]."""
    if printing(x):
        return node("cos", x)
    y, low, m = _reduced(x)
    sine, cosine = _kernels(y, low)
    even = 1.0 - abs(m)
    return select(abs(even) > 0.0, even * cosine, -(m * sine))


# ---- the angle of a vector -----------------------------------------------------------------------------------


def atan2(y: Scalar, x: Scalar) -> Any:
    """Return the angle of the vector (x, y) from the x axis, from -pi to pi [rad]; 0 for the zero vector."""
    if printing(x) or printing(y):
        return node("atan2", y, x)
    large, small = maximum(abs(x), abs(y)), minimum(abs(x), abs(y))
    large = select(large > 0.0, large, 1.0)
    # atan t = atan c + atan((t - c)/(1 + c t)) with c = 0, 1/2, 1 (s_atan.c); small - c large is exact
    half, one = small > 0.4375 * large, small > 0.6875 * large
    c = select(one, 1.0, select(half, 0.5, 0.0))
    u, rest = _ratio((small - c * large, 0.0), _sum(large, c * small))
    z = u * u
    s, s_low = u, rest - u * (z * _polynomial(_ATAN, z))
    base = tuple(select(one, a, select(half, b, 0.0)) for a, b in zip(_ATAN_ONE, _ATAN_HALF, strict=True))
    # quarter turns +- that angle
    steep, behind = abs(y) > abs(x), x < 0.0
    quarters = select(steep, 1.0, select(behind, 2.0, 0.0))
    turn = select(steep, select(behind, 1.0, -1.0), select(behind, -1.0, 1.0))
    b, b_low = _sum(quarters * _QUARTER[0], turn * base[0])
    b_low = b_low + (quarters * _QUARTER[1] + turn * base[1])
    angle, error = _sum(b, turn * s)
    angle = angle + (error + (b_low + turn * s_low))
    return select(y < 0.0, -angle, angle)


# ---- powers --------------------------------------------------------------------------------------------------


def _fraction(x: Scalar) -> tuple[Scalar, Pair]:
    """Return exponent k and fraction f = (m - 1)/(m + 1) of a positive normal number m 2^k with m nearest to 1."""
    k = exponent(x)
    m = x * power_of_two(-k)
    high = m > 1.4142135623730951
    m, k = select(high, 0.5 * m, m), select(high, k + 1.0, k)
    return k, _ratio((m - 1.0, 0.0), _sum(m, 1.0))


def _log(x: Scalar) -> Pair:
    """Return the natural logarithm of a positive normal number as a pair, with a relative error of 2^-64."""
    k, f = _fraction(x)
    z = _times(f, f)
    c, c_low = _sum(_THIRD[0], z[0] * _polynomial(_ATANH, z[0]))
    g = _times(f, _times(z, (c, c_low + _THIRD[1])))
    s, e = _sum(f[0], g[0])
    s, e = 2.0 * s, 2.0 * (e + (f[1] + g[1]))
    total, rest = _sum(k * _LN2[0], s)
    return _sum(total, rest + (e + k * _LN2[1]))


def _exp(y: Pair) -> Any:
    """Return exp of a pair: the pair is reduced to n ln 2 + r; fdlibm's rational approximation gives exp(r)."""
    n = minimum(maximum(nearest(y[0] * 1.44269504088896338700), -1021.0), 1022.0)
    high, low = y[0] - n * _LN2[0], n * _LN2[1] - y[1]
    r = high - low
    z = r * r
    c = r - z * _polynomial(_EXP, z)
    return (1.0 - ((low - r * c / (2.0 - c)) - high)) * power_of_two(n)


def exp(x: Scalar) -> Any:
    """Return e^x, for |x| <= 700."""
    return node("exp", x) if printing(x) else _exp((x, 0.0))


def log(x: Scalar) -> Any:
    """Return the natural logarithm of a positive normal number."""
    if printing(x):
        return node("log", x)
    k, f = _fraction(x)
    y = f[0] * f[0]
    s = f[0] * y * _polynomial((1.0 / 3.0, *_ATANH), y)
    return k * _LN2[0] + (2.0 * f[0] + (2.0 * (f[1] + s) + k * _LN2[1]))


def _power(x: Scalars, p: Scalars) -> "Outputs":
    log = _log(minimum(maximum(x[0], 2.0**-1022), 2.0**1022))
    return {"y": [_exp(_times(log, (p[0], 0.0)))]}


@cache
def _traced_power() -> "Function":
    from heavylift.kernel.compiler.function import Function  # with NumPy, which floats do without

    return Function("power", _power, {"x": 1, "p": 1})


def power(x: Scalar, p: Scalar) -> Any:
    """Return x^p for x > 0; x is clipped to the range 2^-1022 to 2^1022."""
    if printing(x) or printing(p):
        return node("power", x, p)
    return _traced_power()(x=[x], p=[p]).y[0] if is_sym(x) or is_sym(p) else _power([x], [p])["y"][0]
