"""Values in plans, choices and messages are computed by IEEE additions, products, divisions and roots only.

The functions of libm, BLAS and LAPACK give other last bits on other processors and systems; so do sums whose order a
library chooses.  The sources are searched for them.  `kernel.elementary` and `kernel.dense` stand in for all of them.
"""

import ast
import sys
from pathlib import Path
from subprocess import run

import pytest

ROOT = Path(__file__).parents[2]
LIBM = {
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "cos", "cosh", "dist", "erf", "erfc", "exp",
    "exp2", "expm1", "gamma", "hypot", "lgamma", "log", "log10", "log1p", "log2", "pow", "sin", "sinh", "sumprod",
    "tan", "tanh",
}  # fmt: skip
# of NumPy, what only makes, shapes, compares, or works on elements by one correctly rounded operation
PLAIN = {
    "abs", "all", "any", "append", "arange", "argmax", "argmin", "array", "asarray", "ascontiguousarray", "block",
    "bool_", "broadcast_arrays", "ceil", "clip", "concatenate", "copy", "degrees", "diff", "dtype", "empty",
    "empty_like", "errstate", "eye", "flatnonzero", "float64", "floor", "frombuffer", "full", "generic", "inf",
    "int64", "integer", "isfinite", "isnan", "ix_", "load", "loadtxt", "maximum", "minimum", "nan", "nan_to_num",
    "ndarray", "ndim", "nonzero", "number", "object_", "ones", "ones_like", "pi", "radians", "ravel", "reshape",
    "rint", "round", "shape", "sign", "sqrt", "stack", "transpose", "tril", "triu", "unique", "where", "zeros",
    "zeros_like",
}  # fmt: skip
ALLOWED = {
    "nodes/devs/statistics.py": {"mean": "the tally's own, one observation after the other"},
    "nodes/fidelity/own.py": {"log10": "digits that are printed", "**": "digits that are printed"},
    "nodes/scene/inputs.py": {"log10": "digits that are written"},
    "nodes/scene/keys/parts/kinematics.py": {"@": "its arrays hold Python floats, whose products are summed in order"},
    "nodes/scene/text/units.py": {"**": "powers of fractions are exact"},
}
# of the kernel, whose text of equations is full of products of symbols and of exact arrays: matrices aside
ELEMENTS = {
    "outer",
    "cross",
    "diag",
    "pad",
    "bincount",  # adds in the order of its arguments
    "cumsum",
    "split",
    "linspace",
    "ndindex",
    "column_stack",
    "argsort",
    "real",
    "searchsorted",
}
PRINTS = "what it finds is printed, and nothing follows from it"
TELLS_STEPS = "judges fixed steps by margins of a tenth and tells three digits"
KERNEL = {
    "kernel/algebra/attitudes.py": "recorded quaternions, in one order; nothing follows from them",
    "kernel/analysis/modes.py": "printed; a ramp has a period's first five digits",
    "kernel/analysis/corrector.py": "eigenvalues: whether a rest is stable is reported, and nothing follows from it",
    "kernel/analysis/poses.py": "motions that loops allow; lifts, whose plans take over what rests, have none",
    "kernel/analysis/linear.py": "matrices that are handed out; no simulation continues with them",
    "kernel/compiler/derivative.py": "derivatives for those matrices",
    "kernel/multibody/continuous_angles.py": "whether axes are parallel, by a wide margin",
    "kernel/equations/coordinates.py": PRINTS,
    "kernel/methods/stability.py": TELLS_STEPS,
    "kernel/simulation/safeguards/step_check.py": TELLS_STEPS,
    "kernel/forces/springs.py": "whether the matrices of a bushing can be",
    "kernel/forces/radiation.py": "whether the memory of the water is passive",
    "kernel/model/checks.py": "whether the added mass of a pair of bodies resists every motion",
    "kernel/methods/radau.py": "its amplification on floats, which judges fixed steps",
    "kernel/compiler/llvm_function.py": "writes code",
    "kernel/islands/dense_output.py": "values between samples; nothing follows from them",
}
SYMBOLS = "equations on symbols, or on objects whose products are summed in order"
BODIES, ALGEBRA = "kernel/multibody/flexible", ("arrays.py", "eigenvalues.py")
FLEXIBLE = {"attachment.py": SYMBOLS, "small_deflections.py": SYMBOLS}
# limits judge, outside
FOLDERS = ("nodes/devs", "nodes/plan", "nodes/models", "nodes/statics", "nodes/fidelity", "nodes/scene")


def sources():
    found = [p.relative_to(ROOT).as_posix() for folder in FOLDERS for p in sorted((ROOT / folder).rglob("*.py"))]
    return found


def used(tree):
    """Line and name of everything whose last bit a library decides."""
    for n in ast.walk(tree):
        match n:
            case ast.ImportFrom(module="math" | "cmath"):
                yield from ((n.lineno, a.name) for a in n.names if a.name in LIBM)
            case ast.ImportFrom(module=str() as name) if name.split(".")[0] in {"numpy", "scipy"}:
                yield from ((n.lineno, a.name) for a in n.names)
            case ast.Attribute(value=ast.Name(id="math" | "cmath"), attr=name) if name in LIBM:
                yield n.lineno, f"math.{name}"
            case ast.Attribute(value=ast.Name(id="np" | "numpy"), attr=name) if name not in PLAIN:
                yield n.lineno, f"np.{name}"
            case ast.BinOp(op=ast.MatMult()):
                yield n.lineno, "@"
            case ast.BinOp(op=ast.Pow(), left=left, right=right):
                if not (isinstance(left, ast.Constant) and isinstance(right, ast.Constant)):
                    yield n.lineno, "**"
            case ast.Attribute(attr="dot" | "mean" | "std" | "prod" | "cumsum"):
                yield n.lineno, n.attr


@pytest.mark.parametrize("path", sources())
def test_node_code_calls_no_library_function_whose_exact_bits_depend_on_the_library_version(path):
    allowed = ALLOWED.get(path, {})
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    found = sorted({(line, name) for line, name in used(tree) if name not in allowed})
    found = [(line, name) for line, name in found if name not in {"NDArray"}]
    assert found == [], f"{path}: use kernel.algebra.elementary or kernel.algebra.dense"


@pytest.mark.parametrize("path", [p.relative_to(ROOT).as_posix() for p in sorted((ROOT / "kernel").rglob("*.py"))])
def test_the_kernel_bases_decisions_on_its_own_algebra_and_not_on_numpy(path):
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    found = sorted({(line, name) for line, name in used(tree) if name not in {"@", "**"}})
    found = [(line, name) for line, name in found if name.removeprefix("np.") not in ELEMENTS]
    if path in KERNEL:
        assert found, f"{path} needs no exception any more"
    else:
        assert found == [], f"{path}: use kernel.algebra.elementary or kernel.algebra.dense"


@pytest.mark.parametrize("path", [*sorted(p.name for p in (ROOT / BODIES).glob("*.py")), *ALGEBRA])
def test_constants_of_flexible_bodies_are_computed_by_products_in_a_fixed_order(path):
    """A simulation continues with them; twelve digits would not hide the order in which a library sums."""
    folder = "kernel/algebra" if path in ALGEBRA else BODIES
    tree = ast.parse((ROOT / folder / path).read_text(encoding="utf-8"))
    found = [(line, name) for line, name in used(tree) if name in {"@", "**"}]
    found += [(n.lineno, "sum") for n in ast.walk(tree) if isinstance(n, ast.Attribute) and n.attr == "sum"]
    assert bool(found) == (path in FLEXIBLE), f"{path} {found}: see kernel/algebra/arrays.py"


def test_the_test_for_forbidden_functions_finds_every_forbidden_function_in_an_example():
    text = "from scipy.linalg import eigh\nimport math\nfrom math import cos\n"
    text += "x = math.hypot(1, 2) + cos(1) + y**0.5 + 2**3\n"
    text += "z = np.linalg.solve(A, b) @ c"
    assert sorted(used(ast.parse(text))) == [
        (1, "eigh"), (3, "cos"), (4, "**"), (4, "math.hypot"), (5, "@"), (5, "np.linalg"),
    ]  # fmt: skip


def test_elementary_functions_and_dense_algebra_load_without_numpy():
    """Node processes and plans use them, and should start at once."""
    code = (
        "import sys; from heavylift.kernel.algebra import dense, elementary; "
        "elementary.sin(1.0); elementary.power(2.0, 0.3); "
    )
    code += "assert 'numpy' not in sys.modules"
    assert run([sys.executable, "-c", code], capture_output=True, text=True, check=False).stderr == ""
