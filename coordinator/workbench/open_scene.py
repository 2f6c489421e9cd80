"""The open scene: its files are watched, and each save goes to all pages, step by step of its preview.

Pages need only the last message of each kind, so a late or slow page misses nothing, and no messages accumulate.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from heavylift.kernel.errors import HeavyliftError, SceneError
from heavylift.nodes.scene import new_scene
from heavylift.nodes.scene.keys.base import checked_name
from heavylift.nodes.scene.text.files import within
from heavylift.nodes.scenes import bundled
from watchfiles import Change, watch

from .editing import edited, present, reordered, version_of, write
from .picture import Picture
from .preview import previewed
from .results import SCENES
from .runs import SceneRun

WATCHED = (*SCENES, ".csv", ".xlsx", ".stl", ".glb", ".gltf", ".json", ".mtx", ".py")
STEP_ms, QUIET_ms = 10, 50  # between looks at the system's list of changes; after a change, for its last one
AGAIN_ms = 2000  # until folders are looked for again
MOST_FOLDERS = 200  # that are watched

EMPTY = """heavylift: 1
name: {}

practice: 0027/ND                          # factors from the load at rest to the design load
factors: {{weight: 1.03, cog factor: 1.05, dynamics: included, heights: 1.05, wind: 8 m/s}}
limits: {{clearance: 0.5 m, off-lead: 3 deg, touch: 2 m/min, impact: 1.5}}

actions:
  - stage: at rest
    wait: 5 s
"""


class PageMessage(NamedTuple):
    """A message to the pages: serial number, kind, content as JSON."""

    number: int
    kind: str
    data: bytes


class OpenScene:
    """The folder that the workbench shows and the scene that is open in it; methods may be called from any thread."""

    def __init__(self, folder: Path, scene: Path | None) -> None:
        self.folder, self.scene = folder.resolve(), scene
        self.picture: tuple[int, Picture] | None = None
        """The states that pages show, with their number."""
        self.run = SceneRun(self.say)
        self._lock = threading.RLock()
        self._messages: dict[str, PageMessage] = {}
        self._number = 0
        self._listeners: set[Callable[[], None]] = set()
        self._changed, self._closing = threading.Event(), threading.Event()
        self._seen = ""  # the state of the files that was previewed last
        self._threads = [threading.Thread(target=x, daemon=True, name=x.__name__) for x in (self._look, self._work)]

    def __enter__(self) -> OpenScene:
        self._tell_scene()
        self._changed.set()
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.run.end()
        self._closing.set()
        self._changed.set()
        self._ring()

    @property
    def closing(self) -> bool:
        """Whether the server is closing and pages should disconnect."""
        return self._closing.is_set()

    # ---- pages -------------------------------------------------------------------------------------------

    def listen(self, ring: Callable[[], None]) -> None:
        """Register a function that is called whenever there are new messages for the pages."""
        with self._lock:
            self._listeners.add(ring)

    def forget(self, ring: Callable[[], None]) -> None:
        """Remove a function registered by `listen`."""
        with self._lock:
            self._listeners.discard(ring)

    def since(self, number: int) -> list[PageMessage]:
        """Return the latest message of each kind with a serial number above this one, for a page that reconnects."""
        with self._lock:
            return sorted(x for x in self._messages.values() if x.number > number)

    def say(self, kind: str, data: dict[str, Any], picture: Picture | None = None) -> None:
        """Send a message to all pages."""
        with self._lock:
            self._number += 1
            if picture is not None:
                self.picture = self._number, picture
            self._messages[kind] = PageMessage(self._number, kind, msgspec.json.encode(data | {"number": self._number}))
        self._ring()

    def _ring(self) -> None:
        with self._lock:
            listeners = list(self._listeners)
        for ring in listeners:
            ring()

    def drawings(self, number: int, k: int) -> list[dict[str, str]] | None:
        """Return the drawings of state `k` of the lift; None if the scene has changed since this picture number."""
        with self._lock:
            found = self.picture
        if found is None or found[0] != number or not 0 <= k < len(found[1].states):
            return None
        return found[1].drawings(k)

    # ---- files -------------------------------------------------------------------------------------------

    @property
    def own(self) -> bool:
        """Whether the scene file is in the opened folder and may therefore be changed."""
        return self.scene is not None and self.scene.resolve().is_relative_to(self.folder)

    def open(self, name: str) -> None:
        """Open another scene of the folder, or a bundled one; raises SceneError if there is none."""
        try:
            path = within(self.folder, self.folder / name)
        except ValueError as error:
            raise SceneError(f"'{name}': {error}") from None
        path = path if path.is_file() else bundled().get(name, path)
        if not path.is_file() or path.suffix not in SCENES:
            raise SceneError(f"'{name}' is not a scene file (.yaml)")
        with self._lock:
            self.scene, self._seen = path, ""
            for kind in ("picture", "checks", "faults", "proposal"):
                self._messages.pop(kind, None)
        self._tell_scene()
        self._changed.set()

    def scenes(self) -> Iterator[Path]:
        """Yield the scene files in the folder and its subfolders."""
        for folder in self._folders():
            yield from sorted(x for x in folder.iterdir() if x.suffix in SCENES and x.is_file() and _is_scene(x))

    def save(self, text: str, version: str) -> dict[str, Any]:
        """Write the scene if it still has this version; return its text and version, and the number of the message to
        pages.

        Pages ignore older messages that arrive later.
        """
        with self._lock:
            path = self._writable()
            write(path, text, version)
            self._messages.pop("proposal", None)
            self._tell_scene()
            number = self._number
        self._changed.set()
        return {"text": text, "version": version_of(text), "number": number}

    def edit(self, edits: list[tuple[list[str | int], str | int | None]], version: str) -> dict[str, Any]:
        """Apply edits to the scene, all or none, if its file still has this version; return the result of `save`.

        If the value is an integer, the list item at the path is moved to this index.
        """
        text = present(self._writable())
        if version_of(text) == version:
            for path, value in edits:
                text = reordered(text, path, value) if isinstance(value, int) else edited(text, path, value)
        return self.save(text, version)

    def _writable(self) -> Path:
        if self.scene is None or not self.own:
            name = self.scene.stem if self.scene else ""
            raise SceneError(f"'{name}' is a bundled scene, which cannot be changed; copy it into the folder first")
        return self.scene

    def copy(self, name: str) -> None:
        """Write the open scene under another name into the folder, and open the copy."""
        scene = self.scene
        if scene is None:
            raise SceneError("choose a scene first")
        self._begin(name, lambda _: present(scene))

    def new(self, name: str, like: str) -> None:
        """Write a new scene into the folder, a copy of a bundled one or an empty one, and open it."""
        if like and like not in bundled():
            raise SceneError(f"there is no scene '{like}' to start from")
        self._begin(name, lambda stem: new_scene(stem, like) if like else EMPTY.format(stem))

    def _begin(self, name: str, text: Callable[[str], str]) -> None:
        stem = name.removesuffix(".yaml")
        try:
            checked_name(stem)
        except ValueError as error:
            raise SceneError(f"{error}; choose a name such as my-lift") from None
        path = self.folder / f"{stem}.yaml"
        try:
            with path.open("x", encoding="utf-8", newline="") as file:
                file.write(text(stem))
        except FileExistsError:
            raise SceneError(f"{path.name} exists already; choose another name") from None
        self.open(path.name)

    def ask(self, do: str, text: str) -> str:
        """Start a run of the open scene (see `SceneRun.start`), or give an order to the run in progress."""
        if self.scene is None:
            raise SceneError("choose a scene first")
        if do not in ("run", "sweep", "limits", "plan"):
            return self.run.order(do, text)
        self.run.start(self._writable() if do == "plan" else self.scene, self.folder, do, text)
        return ""

    def _folders(self) -> list[Path]:
        """Return the opened folder and its subfolders, nearest first, without hidden ones and up to a maximum
        number."""
        found, next_ = [self.folder], [self.folder]
        while next_ and len(found) < MOST_FOLDERS:
            inner = (
                x for above in next_ for x in above.iterdir() if x.name[0] not in "._" and x.name != "node_modules"
            )
            next_ = sorted(x for x in inner if x.is_dir() and not x.is_symlink())
            found += next_
        return found[:MOST_FOLDERS]

    def _tell_scene(self) -> None:
        """Send the text and version of the open scene to all pages, with the names of all scenes."""
        names = [x.relative_to(self.folder).as_posix() for x in self.scenes()]
        message: dict[str, Any] = {"scenes": names, "bundled": sorted(bundled()), "file": ""}
        with self._lock:  # nobody may say a newer text between the reading and the saying of this one
            if self.scene is not None:
                text, own = present(self.scene), self.own
                name = self.scene.resolve().relative_to(self.folder).as_posix() if own else self.scene.name
                message |= {"file": name, "own": own, "text": text, "version": version_of(text)}
            self.say("scene", message)

    # ---- threads -----------------------------------------------------------------------------------------

    def _look(self) -> None:
        """Watch the files in all folders, including folders created later, and set `_changed` when a file changes."""
        while not self.closing:
            folders = self._folders()
            apart = [self.scene.resolve().parent] if self.scene and not self.own else []
            changes = watch(
                *folders, *apart, watch_filter=_watched, step=STEP_ms, debounce=QUIET_ms, stop_event=self._closing,
                recursive=False, raise_interrupt=False, ignore_permission_denied=True, rust_timeout=AGAIN_ms,
                yield_on_timeout=True,
            )  # fmt: skip
            for found in changes:
                if found:
                    self._changed.set()
                if folders != self._folders():
                    break

    def _work(self) -> None:
        """Preview the last saved state of the files, again after each change."""
        while True:
            self._changed.wait()
            self._changed.clear()
            if self.closing:
                return
            try:
                self._preview()
            except (HeavyliftError, OSError) as error:
                self.say("faults", {"version": "", "faults": [_unread(self.scene or self.folder, error)]})

    def _preview(self) -> None:
        scene, seen = self.scene, self._state()
        if scene is None:
            return self._tell_scene()
        if seen == self._seen:
            return
        self._seen, text = seen, present(scene)
        version = version_of(text)
        self._tell_scene()
        self.say("busy", {"version": version, "busy": True})
        for kind, data, picture in previewed(scene, text):
            if self.closing or (self._changed.is_set() and self._state() != seen):
                self._seen = ""
                return
            self.say(kind, {"version": version, **data}, picture)
        self.say("busy", {"version": version, "busy": False})

    def _state(self) -> str:
        """Return a text that differs whenever a file that the scene may read has changed."""
        if self.scene is None:
            return ""
        found = [version_of(present(self.scene))]
        for folder in self._folders() if self.own else ():
            files = sorted(x for x in folder.iterdir() if _watched(Change.modified, x.name))
            found += [f"{x}{x.stat().st_mtime_ns}" for x in files if x != self.scene]
        return " ".join(found)


def _watched(_: Change, path: str) -> bool:
    return not Path(path).name.startswith(".") and (path.endswith(WATCHED) or Path(path).is_dir())


def _is_scene(path: Path) -> bool:
    """Whether a file begins as a scene does."""
    try:
        with path.open("rb") as file:
            return any(line.startswith(b"heavylift:") for line in file.read(1 << 14).splitlines())
    except OSError:
        return False


def _unread(path: Path, error: Exception) -> dict[str, Any]:
    return {"file": path.name, "line": 1, "column": 1, "path": "", "sentence": str(error), "hint": ""}
