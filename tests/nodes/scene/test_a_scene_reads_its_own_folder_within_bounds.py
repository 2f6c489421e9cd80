"""No file outside a scene's folder is read or quoted, and each read has a size limit."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load, parse
from heavylift.nodes.scene.text import MOST_DIGITS, MOST_VALUES
from heavylift.nodes.scene.text.files import LARGEST
from heavylift.nodes.scene.text.source import DEEPEST

SECRET = "password: correct horse\n"


def refused(scene: Path | str, overrides: tuple[str, ...] = ()) -> str:
    with pytest.raises(SceneError) as refusal:
        load(scene, overrides) if isinstance(scene, Path) else parse(scene, overrides=overrides)
    assert "horse" not in str(refusal.value)
    return str(refusal.value)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "secret.yaml").write_text(SECRET)
    (tmp_path / "secret.csv").write_text(SECRET)
    (tmp_path / "secret").write_text(SECRET)
    (tmp_path / "scenes" / "below").mkdir(parents=True)
    (tmp_path / "scenes" / "link.yaml").symlink_to(tmp_path / "secret.yaml")
    (tmp_path / "scenes" / "link.csv").symlink_to(tmp_path / "secret.csv")
    (tmp_path / "scenes" / "links").symlink_to(tmp_path)
    (tmp_path / "scenes" / "own").write_text(SECRET)
    os.mkfifo(tmp_path / "scenes" / "pipe.yaml")
    return tmp_path / "scenes"


OUTSIDE = "is outside of the scene's folder"
BASES = {
    "../secret.yaml": OUTSIDE,
    "link.yaml": OUTSIDE,
    "links/secret.yaml": OUTSIDE,
    "below/../../secret.yaml": OUTSIDE,
    "/etc/x.yaml": OUTSIDE,
    "own": "is neither a file .yaml nor the name of a bundled scene",
    "/dev/zero": "is neither a file .yaml nor the name of a bundled scene",
    "pipe.yaml": "cannot be read: it is a pipe or a device, not a file",
    "below": "is neither a file .yaml",
    "nul\\0.yaml": r"nul\x00.yaml",
}


@pytest.mark.parametrize(("base", "told"), BASES.items())
def test_files_outside_the_folder_of_a_scene_cannot_be_extended(folder: Path, base: str, told: str) -> None:
    (folder / "case.yaml").write_text(f'heavylift: 1\nextends: "{base}"\nname: case\n')
    text = refused(folder / "case.yaml")
    assert f"{folder / 'case.yaml'}:2:11: error: extends: " in text
    assert told in text


def test_a_scene_may_extend_a_file_in_a_subfolder_that_refers_to_the_parent_folder(folder: Path) -> None:
    (folder / "base.yaml").write_text("heavylift: 1\nextends: pendulum\nname: base\n")
    (folder / "below" / "middle.yaml").write_text("extends: ../base.yaml\nseed: 3\n")
    (folder / "case.yaml").write_text("extends: below/middle.yaml\nname: case\n")
    assert (load(folder / "case.yaml").plan.name, load(folder / "case.yaml").plan.seed) == ("case", 3)


MATRICES = """\
heavylift: 1
name: m
end: 1 s
mechanism:
  bodies:
    jib: {matrices: {nodes: FILE, mass: FILE, stiffness: FILE}}
  joints:
    turn: {type: revolute, child: jib, axis: [0, 0, 1]}
"""


def test_matrices_are_read_from_the_folder_of_the_scene_and_not_quoted_in_errors(folder: Path) -> None:
    (folder / "own.csv").write_text("1,2,3\n4,horse,6\n")
    (folder / "own.npz").write_bytes(b"horse")
    np.savez(folder / "text.npz", nodes=np.array(["horse"]))
    np.savez(folder / "code.npz", nodes=np.array([{}], object))
    message = {
        "../secret.csv": OUTSIDE,
        "link.csv": OUTSIDE,
        "own.csv": "'own.csv' cannot be read as numbers at row 1, column 2",
        "own.npz": "'own.npz' cannot be read as numbers",
        "text.npz": "'text.npz' cannot be read as numbers",
        "code.npz": "'code.npz' cannot be read as numbers",
    }
    for file, sentence in message.items():
        (folder / "m.yaml").write_text(MATRICES.replace("FILE", file))
        text = refused(folder / "m.yaml")
        assert f"{folder / 'm.yaml'}:6:11: error: mechanism.bodies.jib.matrices: " in text
        assert sentence in text


def bomb(levels: int, each: int) -> str:
    lines = ["heavylift: 1", "a0: &a0 [x, x]"]
    lines += [f"a{i + 1}: &a{i + 1} [{', '.join([f'*a{i}'] * each)}]" for i in range(levels)]
    return "\n".join(lines)


HEAD = "heavylift: 1\nname: x\nend: 1 s\n"
BOMBS = {
    "aliases of aliases": (bomb(9, 9), f"more than {MOST_VALUES} values"),
    "aliases of aliases in mappings": (
        bomb(30, 2).replace("[", "{k: [").replace("]", "]}"),
        f"more than {DEEPEST} levels",
    ),
    "brackets": (HEAD + "a: " + "[" * 100_000, f"nested deeper than {DEEPEST} levels"),
    "braces": (HEAD + "a: " + "{a: " * 100_000, f"nested deeper than {DEEPEST} levels"),
    "dashes": (HEAD + "a:\n" + "- " * 100_000, f"nested deeper than {DEEPEST} levels"),
    "indents": (HEAD + "".join(f"{' ' * i}a:\n" for i in range(500)), f"nested deeper than {DEEPEST} levels"),
    "digits": (HEAD + f"seed: {'9' * 6000}\n", f"a number has at most {MOST_DIGITS} digits, this one has 6000"),
    "hexadecimal digits": (HEAD + f"seed: 0x{'f' * 6000}\n", f"a number has at most {MOST_DIGITS} digits"),
    "a word that is called a number": (HEAD + "seed: !!int many\n", "'many' is not a number"),
    "a fraction that is called a number": (HEAD + "seed: !!int 1.5\n", "'1.5' is not a number"),
    "unknown keys": (HEAD + "".join(f"k{i}: 1\n" for i in range(3000)), "more than 200 errors in scene.yaml"),
    "a long line": (HEAD + "a: {" + "b: 1, " * 4000 + "}\n", "errors in scene.yaml"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_a_scene_with_endless_yaml_expansion_is_refused_with_a_short_message(case: str) -> None:
    text, message = BOMBS[case]
    answer = refused(text)
    assert message in answer
    assert len(answer) < 250_000


def test_settings_may_not_read_files_outside_the_folder_of_the_scene() -> None:
    base = HEAD + "extends: pendulum\n"
    assert "levels" in refused(base, (f"a={'[' * 5000}",))
    assert "digits" in refused(base, (f"seed={'9' * 5000}",))
    assert "at most 40 levels, this one has 500" in refused(base, (f"{'a.' * 499}a=1",))
    for number in ("9" * 5000, "\u00b2", "\u0663"):
        assert number[:20] in refused(base, (f"mechanism.{number}=1",))


def test_a_scene_must_be_a_regular_file_of_limited_size(folder: Path) -> None:
    assert refused(folder / "pipe.yaml").endswith("cannot be read: it is a pipe or a device, not a file")
    assert refused(Path("/dev/zero")).endswith("cannot be read: it is a pipe or a device, not a file")
    assert refused(folder).endswith("cannot be read: Is a directory")
    (folder / "long.yaml").write_text("#" * (LARGEST + 1))
    assert refused(folder / "long.yaml").endswith(f"cannot be read: it has more than {LARGEST} bytes")
