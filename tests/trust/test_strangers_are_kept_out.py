"""Data from others control no terminal, run in no spreadsheet, do not expand without bound, and are not run as code."""

import json
import sys
from pathlib import Path
from random import Random

import msgspec
import pytest
from heavylift.coordinator.sweeps import Variant, received
from heavylift.kernel import SPACES, ProtocolError, printable

sys.path.insert(0, str(Path(__file__).parents[1] / "full"))

import attacks


@pytest.mark.parametrize("attack", [attacks.cells, attacks.workbooks, attacks.viewers, attacks.pickles])
def test_clients_without_a_password_cannot_attack_a_run(attack, tmp_path: Path) -> None:
    tries = list(attack(tmp_path, True))
    assert len(tries) >= 8
    assert [what for what, promised in tries if not promised] == []


@pytest.mark.large
@pytest.mark.parametrize("attack", [attacks.terminal, attacks.workers])
def test_no_command_lets_untrusted_input_files_or_clients_break_its_security_promises(attack, tmp_path: Path) -> None:
    assert [what for what, promised in attack(tmp_path, False) if not promised] == []


def test_each_command_with_untrusted_input_has_a_test_that_attacks_it() -> None:
    assert set(attacks.LINES) <= set(attacks.commands())


def test_control_characters_are_shown_escaped_and_json_stays_valid() -> None:
    for code in range(0x20, 0x110000):
        shown = printable(chr(code), keep=SPACES)
        assert shown == chr(code) or shown.isascii()
        assert shown.isprintable() or shown in SPACES
        if shown != chr(code):
            assert json.loads(f'"{shown}"') == chr(code)


def test_a_result_row_of_a_study_from_another_process_is_validated_or_refused() -> None:
    random, variant = Random(1), Variant(3, (), ())
    values = [3, 4, -1, 1 << 63, 0.5, float("nan"), "done", "\x1b[2J", b"x", [1], {"a": 1}, None, True, "x" * 200_000]
    names = ["number", "status", "sentence", "digest", "use", "input/x", "recording", "\n", "host", "limit"]
    right = 0
    for _ in range(3000):
        row = {"number": 3, "status": "done", "sentence": ""}
        row |= {random.choice(names): random.choice(values) for _ in range(random.randrange(3))}
        data = bytearray(msgspec.msgpack.encode(row))
        if random.random() < 0.2:
            data[random.randrange(len(data))] = random.randrange(256)
        try:
            found = received(bytes(data), variant)
        except ProtocolError:
            continue
        right += 1
        assert found["number"] == 3
        assert not any(name.startswith("input/") for name in found)
        assert all(isinstance(x, str | int | float | bytes | None) for x in found.values())
        assert all(printable(x, keep=SPACES) == x for x in [*found, *found.values()] if isinstance(x, str))
    assert right > 300


def test_a_result_row_of_a_study_that_is_not_bytes_is_refused() -> None:
    with pytest.raises(ProtocolError, match="returned something other than an encoded row"):
        received({"number": 3}, Variant(3, (), ()))
