"""The folder of a study: its definition, its rows so far, kept recordings, the page.

study.json       definition of the study; the folder can only be continued by the same study
parts/           rows as they come, one Parquet file for each second or so, so that a kill loses no more
rows.parquet     all rows, written when the study stops; recordings/000012.mcap, summary.html
"""

import fcntl
import json
import os
import shlex
from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
from heavylift.kernel.errors import OutputError, RecordingError, SceneError, printable
from heavylift.kernel.version import __version__, install
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.write.outputs import file_path, writing

from .axes import Axis, Variant
from .variant import RESPONSE as RESPONSE, Row, Task

if TYPE_CHECKING:
    import pandas

ABOUT, PARTS, ROWS, RECORDINGS = "study.json", "parts", "rows.parquet", "recordings"
INPUT = "input/"  # before the name of a column: what was varied


@dataclass(frozen=True)
class StudyPlan:
    """Definition of a study: scene, axes, variants, sampling design with number of draws (0: full grid), and seed."""

    scene: LoadedScene
    axes: Sequence[Axis]
    variants: Sequence[Variant]
    design: str
    sample: int
    seed: int

    def about(self, task: Task) -> dict[str, Any]:
        """Return the definition of the study as plain data, as stored in the folder."""
        identity = [asdict(task), [v.settings for v in self.variants], self.design, __version__]
        return {
            "heavylift study": 1,
            "scene": self.scene.plan.name,
            "varied": [axis.label for axis in self.axes],
            "variants": len(self.variants),
            "design": self.design or "grid",
            "seed": self.seed,
            "heavylift": __version__,
            "set": list(self.scene.settings),
            "limit": f"{task.limit_s:g} s",
            "keep": task.keep,
            "judged": task.judged,
            "responses": [f"{name}={function}" for name, function in task.responses],
            "fingerprint": sha256(json.dumps(identity).encode()).hexdigest(),
        }


class Study(AbstractContextManager["Study"]):
    """A study on disk, opened by one process at a time; rows are only appended."""

    def __init__(self, folder: str | Path, plan: StudyPlan, task: Task) -> None:
        """Begin or continue a study; OutputError if the folder holds something else, SceneError without `sweep`."""
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise SceneError("a study needs pyarrow; install heavylift[sweep]") from None
        self.path, self.plan, self.task = file_path(folder), plan, task
        about, file = plan.about(task), self.path / ABOUT
        hidden = file.with_suffix(".new")
        with writing(self.path):
            if file.is_file():
                self._check(_known(file), about)
            elif self.path.exists() and (
                not self.path.is_dir() or {x.name for x in self.path.iterdir()} - {hidden.name}
            ):
                raise OutputError(f"{self.path}: exists and is not a study; choose another folder with -o")
            else:
                self.path.mkdir(parents=True, exist_ok=True)
                hidden.write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")
                hidden.rename(file)
            for name in (PARTS, RECORDINGS):
                (self.path / name).mkdir(exist_ok=True)
            self._lock = open(file, encoding="utf-8")  # noqa: SIM115 - closed with the study
            try:
                fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise OutputError(
                    f"{self.path}: another process is running this study; wait for it, or stop it"
                ) from None
        self.rows: dict[int, Row] = {row["number"]: row for row in self._read() if row["status"] != "lost"}
        self._number = len(list((self.path / PARTS).iterdir()))

    def _check(self, found: dict[str, Any], about: dict[str, Any]) -> None:
        if found.get("fingerprint") == about["fingerprint"]:
            return
        names = [name for name in about if name != "fingerprint"]
        differing = [f"{name} {found.get(name)}" for name in names if found.get(name) != about[name]]
        message = ", ".join(differing) or "other values, or another text of the scene"
        made = str(found.get("heavylift"))
        to = "" if made == __version__ else f", or {install(printable(made, 60))}, which began it"
        raise OutputError(f"{self.path}: holds another study ({message}); choose another folder with -o{to}")

    @property
    def waiting(self) -> list[Variant]:
        """Variants of the study that have no row of results yet."""
        return [variant for variant in self.plan.variants if variant.number not in self.rows]

    def append(self, rows: Sequence[Row]) -> None:
        """Append rows to the study; when this returns, the rows are on disk."""
        if not rows:
            return
        import pyarrow
        from pyarrow import parquet

        whole = [self._whole(row) for row in rows]
        self.rows |= {row["number"]: row for row in whole}
        self._number += 1
        part = self.path / PARTS / f"{self._number:08d}.parquet"
        with writing(part):
            hidden = part.with_suffix(".new")
            parquet.write_table(pyarrow.Table.from_pylist(_even(whole)), hidden)
            with open(hidden, "rb+") as file:
                os.fsync(file.fileno())
            hidden.rename(part)

    def _whole(self, row: Row) -> Row:
        """Return a worker's row, completed by settings, inputs and the command that repeats it."""
        variant = self.plan.variants[row["number"]]
        found = {key: value for key, value in row.items() if key != "recording"}
        found["settings"] = list(variant.settings)
        found |= {INPUT + axis.label: x for axis, x in zip(self.plan.axes, variant.values, strict=True)}
        sets = " ".join(f"--set {shlex.quote(setting)}" for setting in [*self.plan.scene.settings, *variant.settings])
        name = f"{self.plan.scene.plan.name}-{variant.number:06d}.mcap"
        found["command"] = f"heavylift run {shlex.quote(self.plan.scene.typed)} {sets} -o {name}"
        if data := row.get("recording"):
            path = self.path / RECORDINGS / f"{variant.number:06d}.mcap"
            with writing(path):
                path.write_bytes(data)
            found["recording"] = str(path.relative_to(self.path))
        return found

    def join(self) -> None:
        """Merge the files of rows in the study's folder into one file."""
        from pyarrow import Table, parquet

        with writing(self.path / ROWS):
            if self.rows:
                hidden = self.path / f"{ROWS}.new"
                parquet.write_table(Table.from_pylist(_even([self.rows[n] for n in sorted(self.rows)])), hidden)
                hidden.rename(self.path / ROWS)
            for part in (self.path / PARTS).iterdir():
                part.unlink()
        self._number = 0

    def to_pandas(self) -> "pandas.DataFrame":
        """Return all rows as a DataFrame, indexed by variant."""
        try:
            import pandas
        except ImportError:
            raise RecordingError("a DataFrame needs pandas; install heavylift[pandas] or read rows.parquet") from None
        return pandas.DataFrame(_even([self.rows[n] for n in sorted(self.rows)])).set_index("number")

    def _read(self) -> list[Row]:
        from pyarrow import ArrowException, parquet

        found: list[Row] = []
        for path in [self.path / ROWS, *sorted((self.path / PARTS).glob("*.parquet"))]:
            try:
                found += parquet.read_table(path).to_pylist() if path.exists() else []
            except (ArrowException, OSError) as error:
                raise RecordingError(
                    f"{path}: cannot be read ({str(error).splitlines()[0]}); remove it; its variants will be run again"
                ) from None
        return [{key: value for key, value in row.items() if value is not None} for row in found]

    def __exit__(self, *_: object) -> None:
        self._lock.close()


def _known(file: Path) -> dict[str, Any]:
    try:
        return msgspec.json.decode(file.read_bytes(), type=dict[str, Any])
    except msgspec.MsgspecError:
        raise OutputError(f"{file}: is not the definition of a study; choose another folder with -o") from None


def _even(rows: Sequence[Row]) -> list[Row]:
    """Return rows that all have the columns of any of them, in order of appearance."""
    names = dict.fromkeys(name for row in rows for name in row)
    return [{name: row.get(name) for name in names} for row in rows]
