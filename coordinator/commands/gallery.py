"""`heavylift gallery`: a page of scenes with a picture of each, as GALLERY.md and its pictures.

The text of a scene is the comment at its beginning, and a line of it says how to draw the picture: `# See it: heavylift
plot NAME.mcap 'rope/tension/*'`; without this line the lift itself is drawn. A folder of a user's scenes can become a
page as well.
"""

import shlex
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from heavylift.coordinator.run import run
from heavylift.kernel.errors import RecordingError
from heavylift.nodes.scene import LoadedScene
from heavylift.recordings.format.text import GENERATOR
from heavylift.recordings.write.outputs import output_path
from heavylift.recordings.write.partfile import PartFile

SEE = "See it:"
WIDTH, COLOURS = 900, 255  # [px], and of the palette: a picture of some kB
HEAD = """# Scenes, and what they show

Each comes with heavylift: run it by its name, or copy it (`heavylift new mine --like NAME`).  Made by
`heavylift gallery -o nodes/scenes --force`, of your own scenes by `heavylift gallery my-*.yaml -o DIR`.
"""
YARD = "vlcc"  # that is drawn with the bundled scenes
OF_YARD = f"""
## {YARD}

A [yard](../yard/YARD.md) of 200 blocks.

![{YARD}](pictures/{YARD}.png)

    heavylift run {YARD} --report {YARD}.svg
"""


def page(scenes: Iterable[LoadedScene]) -> str:
    """Return a gallery page about some scenes as Markdown, with pictures in `pictures/`; for all bundled scenes the
    page includes the bundled yard."""
    from heavylift.nodes.scenes import bundled

    scenes = [*scenes]
    whole = {scene.path for scene in scenes} == {*bundled().values()}
    return HEAD + "".join(_entry(scene) for scene in scenes) + (OF_YARD if whole else "")


def draw_yard(folder: Path, force: bool = False) -> Path:
    """Run the bundled yard in this process, and draw its schedule into the folder."""
    from heavylift.coordinator.yards.running import run_yard

    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as place:
        drawn = Path(place) / "drawn.png"
        run_yard(YARD, in_process=True, exports=[drawn])
        with PartFile(output_path(folder / f"{YARD}.png"), "a picture", (".png",), force) as file, file.writing():
            _shrunk(drawn, file.stream)
    return file.path


def draw(scene: LoadedScene, folder: str | Path, force: bool = False) -> Path:
    """Run a scene in this process, draw its picture into the folder, and return the path of the picture."""
    from heavylift.recordings import curves, file_path, plot, storyboard

    folder = file_path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(f"{folder}: cannot be made ({error.strerror}); choose another folder") from None
    out = output_path(folder / f"{scene.plan.name}.png")
    words = shlex.split(_described(scene)[1])[3:]  # behind `heavylift plot NAME.mcap`
    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as place:
        recording, drawn = Path(place) / f"{scene.plan.name}.mcap", Path(place) / "drawn.png"
        run(scene, recording, in_process=True)
        if "--lift" in words:
            storyboard(recording, drawn)
        elif words:
            curves(recording, words, drawn)
        else:
            plot(recording, drawn)
        with PartFile(out, "a picture", (".png",), force) as file, file.writing():
            _shrunk(drawn, file.stream)
    return file.path


def _described(scene: LoadedScene) -> tuple[str, str]:
    """Return the first paragraph of a scene's opening comment, and the command that draws it."""
    lines = []
    for line in scene.text.splitlines():
        if not line.startswith("#") or line.strip() == "#":
            break
        lines.append(line.removeprefix("#").strip())
    see = next((line.removeprefix(SEE).strip() for line in lines if line.startswith(SEE)), "")
    message = " ".join(line for line in lines if not line.startswith(SEE))
    return message, see or f"heavylift plot {scene.plan.name}.mcap --lift"


def _entry(scene: LoadedScene) -> str:
    from heavylift.nodes.scene import check
    from heavylift.nodes.scenes import bundled

    name = scene.plan.name
    message, see = _described(scene)
    size = check(scene).lines[0].partition(": ")[2]
    called = name if scene.path in bundled().values() else scene.path.name
    return (
        f"\n## {name}\n\n{message}\n\n![{name}](pictures/{name}.png)\n\n"
        f"    heavylift run {called}\n    {see}\n\n[{scene.path.name}]({scene.path.name}): {size}.\n"
    )


def _shrunk(drawn: Path, out: BinaryIO) -> None:
    """Write a drawn picture in the size of the page, with a palette."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    message = PngInfo()
    message.add_text("Software", GENERATOR)

    with Image.open(drawn) as state:
        small = state.convert("RGB")
        small.thumbnail((WIDTH, WIDTH))
        small.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=1).save(out, "png", optimize=True, pnginfo=message)
