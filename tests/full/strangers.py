"""Attacks every promise of SECURITY.md, and counts for each kind the attempts that ended as promised.

    python tests/full/strangers.py               all of it
    python tests/full/strangers.py --short       some tries of each kind, within 15 s
    python tests/full/strangers.py --json        a line of JSON for each kind: kind, tried, as_promised, not

Exit code 1 if anything is not as promised.  All attacks are on processes of its own, on this machine.  Kinds whose
stories stand in tests are those tests, and a try is one of their cases.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

import pytest

TESTS = Path(__file__).parents[1]
sys.path.insert(0, str(TESTS / "full"))

import attacks  # noqa: E402
from fuzz import fuzz  # noqa: E402
from fuzzed import KINDS  # noqa: E402

OWN = {
    "text for terminals": attacks.terminal,
    "cells of CSV and XLSX": attacks.cells,
    "workbooks that unpack": attacks.workbooks,
    "origins at --foxglove": attacks.viewers,
    "code of dask's workers": attacks.workers,
    "pickles among rows": attacks.pickles,
}
JOINS = "coordinator/hosts/test_nobody_joins_under_anothers_name.py"
YARD = "coordinator/hosts/test_a_yard_makes_its_certificates.py"
PRIVATE = "coordinator/transport/test_a_run_is_private.py"
AGAIN = "coordinator/transport/test_recorded_frames_come_again.py"
CODE, TRUST = "trust/test_code_of_others_is_not_run.py", "trust/test_whose_code_is_trusted.py"
OWNER = "kernel/compiler/test_the_cache_is_this_users_own.py"
BYTES = "recordings/test_any_bytes_end_in_a_sentence.py"
FOLDER = "nodes/scene/test_a_scene_reads_its_own_folder_within_bounds.py"
PAGE = "recordings/test_a_page_shows_a_run_that_goes_on.py"
STORIES = {  # files of a kind, and what of them --short plays
    "code in scenes and recordings": ([CODE, TRUST], f"{TRUST}::test_everything_inside_a_trusted_folder_is_trusted"),
    "files of other folders": ([FOLDER], f"{FOLDER}::test_files_outside_the_folder_of_a_scene_cannot_be_extended"),
    "bounded reading": ([BYTES], f"{BYTES}::test_deeply_nested_text_does_not_exhaust_the_stack"),
    "the cache of others": ([OWNER], OWNER),
    "certificates and joins": (
        [JOINS, YARD],
        f"{JOINS}::test_a_remote_process_may_join_only_under_the_name_in_its_certificate",
    ),
    "host, origin, word of a page": (
        [PAGE],
        f"{PAGE}::test_the_live_page_refuses_clients_without_its_secret_token_or_from_another_origin",
    ),
    "sockets and passwords": ([PRIVATE], f"{PRIVATE}::test_a_node_with_a_wrong_password_is_refused"),
    "frames sent again": ([AGAIN], f"{AGAIN}::test_a_message_frame_from_an_earlier_process_of_the_node_is_dropped"),
}
FUZZED = 40  # cases of each kind of file


class Tally:
    """The cases of tests, and how they ended; what this machine cannot try is not among them."""

    def __init__(self) -> None:
        self.ended: dict[str, bool] = {}

    def pytest_runtest_logreport(self, report: Any) -> None:
        """A case has begun, was played, or has ended."""
        if report.failed or (report.when == "call" and report.passed):
            self.ended[report.nodeid] = not report.failed


def stories(short: bool) -> Iterator[tuple[str, Iterator[tuple[str, bool]]]]:
    """The tests of all kinds, as tries."""
    tally = Tally()
    places = [str(TESTS / place) for whole, some in STORIES.values() for place in ([some] if short else whole)]
    pytest.main(["-n", "0", "-p", "no:cacheprovider", *(["--quick"] if short else []), *places], plugins=[tally])
    for kind, (whole, _) in STORIES.items():
        found = {name: ended for name, ended in tally.ended.items() if any(place in name for place in whole)}
        yield kind, iter(found.items() if found else [("no test was played", False)])


def kinds(folder: Path, short: bool) -> Iterator[tuple[str, Iterator[tuple[str, bool]]]]:
    """All kinds with their tries."""
    for number, (kind, attack) in enumerate(OWN.items()):
        (own := folder / f"{number}").mkdir()
        yield kind, attack(own, short)
    yield from stories(short)
    for kind in () if short else KINDS:
        found = fuzz(kind, 1, FUZZED)
        bad = [(message, False) for message in found.found.elements()]
        yield f"spoiled {kind}", iter([*bad, *[("", True)] * (found.cases - len(bad))])


def main() -> int:
    """Attack, and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--short", action="store_true", help="some tries of each kind")
    parser.add_argument("--json", action="store_true", help="a line of JSON for each kind")
    asked = parser.parse_args()
    out: TextIO = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what pytest tells
    wrong = 0
    if not asked.json:
        print(f"{'kind':<32}{'tried':>8}{'as promised':>14}{'not':>6}", file=out)
    with tempfile.TemporaryDirectory(prefix="heavylift-strangers-") as folder:
        for kind, tries in kinds(Path(folder), asked.short):
            ended = list(tries)
            bad = [what for what, promised in ended if not promised]
            row = {"kind": kind, "tried": len(ended), "as_promised": len(ended) - len(bad), "not": len(bad)}
            message = f"{kind:<32}{row['tried']:>8}{row['as_promised']:>14}{row['not']:>6}"
            print(json.dumps(row) if asked.json else message, file=out)
            for what in bad:
                print(f"    not as promised: {what!r}", file=sys.stderr)
            wrong += len(bad)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
