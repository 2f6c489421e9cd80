"""A drawing as an <svg> element in millimetres of its sheet."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from html import escape

from .ink import Path, Text, View, parts

INK, RED = "#111", "#a3182b"
STYLES = {
    "crane": ("#ececec", "#444", 0.22), "block": ("#e8cfc4", INK, 0.35), "deck": ("#d3ab9a", INK, 0.2),
    "hook": ("#555", INK, 0.2), "frame": ("#bcd3d2", INK, 0.25), "world": ("#e4e4e4", "#888", 0.18),
    "rope": ("none", INK, 0.18), "thin": ("none", "#666", 0.12), "axis": ("none", "#666", 0.13),
    "near": ("none", RED, 0.35), "frame line": ("none", INK, 0.35),
}  # fmt: skip


def svg_of(views: Sequence[View], size: tuple[float, float], title: str) -> str:
    """Views on a sheet of this size [mm]."""
    body = "".join(f"<g>{''.join(_items(view, size[1]))}</g>" for view in views)
    fonts = 'font-family="DejaVu Sans, Arial, sans-serif"'
    box = f'viewBox="0 0 {size[0]:g} {size[1]:g}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" class="drawing" role="img" {box} {fonts}>'
    return f"{head}<title>{escape(title)}</title>{body}</svg>"


def _items(view: View, height: float) -> Iterable[str]:
    x0, y0 = view.place

    def at(x: float, y: float) -> tuple[float, float]:
        return x0 + x, height - y0 - y

    for item in view.items:
        for part in parts(item):
            yield _path(part, at) if isinstance(part, Path) else _text(part, *at(*part.at))


def _path(item: Path, at: Callable[[float, float], tuple[float, float]]) -> str:
    fill, stroke, width = STYLES[item.style]
    points = " ".join("{:.2f},{:.2f}".format(*at(x, y)) for x, y in item.points)
    dash = ' stroke-dasharray="3 0.8 0.6 0.8"' if item.style == "axis" else ""
    shape, fill = ("polygon", fill) if item.closed else ("polyline", "none")
    return f'<{shape} points="{points}" fill="{fill}" stroke="{stroke}" stroke-width="{width}"{dash}/>'


def _text(item: Text, x: float, y: float) -> str:
    turn = f' transform="rotate({-item.angle:g} {x:.2f} {y:.2f})"' if item.angle else ""
    bold = ' font-weight="bold"' if item.bold else ""
    place = f'x="{x:.2f}" y="{y:.2f}" font-size="{item.size:g}" text-anchor="{item.anchor}"'
    return f'<text {place}{turn}{bold} fill="{INK}">{escape(item.words)}</text>'
