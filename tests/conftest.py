"""Which tests run when, and which share a worker: those of a file, since they share what it prepares, and all of the
founding lift.

`pytest` runs in some eight minutes on two cores; `pytest --full tests tests/full` runs large tests and matrices, too.
`pytest --quick tests/kernel` ends within a minute: of each test the first case, and of these the cheapest, by what they
took when they ran last.

A scene that leaves open how it is run is asked what is usually meant: measuring that is no matter of most tests, so
only `ASKED` folders and files see it; for all others it runs as if it had asked nothing, in programs that they
start as well.
"""

from __future__ import annotations

import gc
import os
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any

import pytest
from heavylift.kernel import allowed
from heavylift.nodes.scene import loaded_scene
from heavylift.nodes.scene.text import library

ONE_RUN = "turnover"  # the folder whose tests read one and the same run
MATRICES = "full"  # the one whose files are shared out by the last of their parameters
SECONDS = "heavylift/seconds"  # in pytest's cache: what each test took when it ran last, with what it prepared
ASKED = {
    "ladder",
    "pages",
    "determinism",
    "test_the_same_bits_on_every_processor.py",
    "test_lifts_are_made_by_mouse_and_forms.py",
    "test_a_moored_crane_lifts.py",
}  # who see what is chosen by default
UNASKED, PYTHONPATH, MEANT = Path(__file__).parent / "unasked", os.environ.get("PYTHONPATH", ""), loaded_scene.MEANT
TYPES = frozenset(library())  # of cranes; tests over all of them run daily with one of each kind, the others by --full
KINDS = frozenset({"crawler-250", "goliath-900", "jib-60", "overhead-100", "twin-hook-600"})
QUICK_s, UNKNOWN_s = 25.0, 0.5  # of tests that --quick runs; of one that has not run here


@pytest.fixture
def code_allowed(tmp_path: Path) -> Iterator[None]:
    """Lets scenes name the Python code that a test writes into its folder."""
    with allowed([str(tmp_path)]):
        yield


@pytest.fixture
def own_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The test's folder, where it stands and where modules are found, which are forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in [name for name, x in sys.modules.items() if str(tmp_path) in str(getattr(x, "__file__", ""))]:
        del sys.modules[name]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--full", action="store_true", help="run what is marked large, too")
    parser.addoption("--quick", action="store_true", help="run what takes less than a minute")


def pytest_configure(config: pytest.Config) -> None:
    gc.set_threshold(50_000)  # as in the command itself
    cache = getattr(config, "cache", None)
    if cache is not None and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Clock(cache))
    message = "large(beyond=0): with --full only, or if it is named; of many cases all but the first so many"
    config.addinivalue_line("markers", message)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    asked = bool(ASKED & {item.path.name, item.path.parent.name})
    loaded_scene.MEANT = MEANT if asked else ()
    os.environ["PYTHONPATH"] = PYTHONPATH if asked else os.pathsep.join([str(UNASKED), PYTHONPATH]).rstrip(os.pathsep)


class Clock:
    """Remembers what each test took."""

    def __init__(self, cache: pytest.Cache) -> None:
        self._cache, self._seconds = cache, Counter[str]()

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self._seconds[report.nodeid] += report.duration

    def pytest_sessionfinish(self) -> None:
        known = self._cache.get(SECONDS, {})
        self._cache.set(SECONDS, known | {test: round(seconds, 2) for test, seconds in self._seconds.items()})


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    from xdist.scheduler import LoadScopeScheduling

    class Shared(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return shared(nodeid)

    return Shared(config, log)


def shared(nodeid: str) -> str:
    """What tests that share a worker have in common."""
    path, _, test = nodeid.partition("::")
    if Path(path).parent.name == MATRICES and " " not in test:  # printed commands share one folder, in their order
        return f"{path} {test.rpartition('-')[2]}"
    return ONE_RUN if Path(path).parent.name == ONE_RUN else path


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("full") or any("::" in arg for arg in config.args):
        return
    cases: Counter[str] = Counter()
    large = _further_types(items)
    large |= {item for item in items if item not in large and _is_large(item, cases)}
    if config.getoption("quick"):
        large |= set(items) - _quick([item for item in items if item not in large], config)
    items[:] = [item for item in items if item not in large]
    config.hook.pytest_deselected(items=list(large))


def _quick(items: list[pytest.Item], config: pytest.Config) -> set[pytest.Item]:
    """The first case of each test, the cheapest of them, as far as the time goes."""
    cache = getattr(config, "cache", None)
    known = cache.get(SECONDS, {}) if cache is not None else {}
    firsts = {item.nodeid.partition("[")[0]: item for item in reversed(items)}.values()
    costs = {item: known.get(item.nodeid, UNKNOWN_s) for item in firsts}
    cheapest = sorted(costs, key=lambda item: (costs[item], item.nodeid))
    return {
        item for item, spent in zip(cheapest, accumulate(costs[x] for x in cheapest), strict=True) if spent <= QUICK_s
    }


def _further_types(items: list[pytest.Item]) -> set[pytest.Item]:
    """Cases of tests over all types of cranes that are not one of each kind."""
    of: dict[str, dict[pytest.Item, str]] = {}
    for item in items:
        values = getattr(item, "callspec", None) and item.callspec.params.values()
        for value in (x for x in values or () if isinstance(x, str) and x in TYPES):
            of.setdefault(item.nodeid.partition("[")[0], {})[item] = value
    everywhere = (cases for cases in of.values() if {*cases.values()} == TYPES)
    return {item for cases in everywhere for item, value in cases.items() if value not in KINDS}


def _is_large(item: pytest.Item, cases: Counter[str]) -> bool:
    """Whether a test waits for --full; `cases`: of each test so far."""
    if not (mark := item.get_closest_marker("large")):
        return False
    test = item.nodeid.partition("[")[0]
    cases[test] += 1
    return cases[test] > int(mark.kwargs.get("beyond", 0))
