"""Output on a terminal: colours and changing lines; control characters in texts are made visible.

This module imports Rich, so it must be imported only for output to a terminal.
"""

import sys
from collections.abc import Iterable

from heavylift.coordinator.stopping import displayed
from rich.console import Console, ConsoleOptions, RenderableType
from rich.live import Live
from rich.segment import Segment


class Terminal(Console):
    """Standard output or standard error; texts are not interpreted as markup, and their control characters are made
    visible."""

    def __init__(self, err: bool = False) -> None:
        stream = sys.stderr if err else sys.stdout
        super().__init__(file=getattr(stream, "drawn", stream), markup=False, emoji=False, highlight=False)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterable[Segment]:
        """Render text for the terminal as Rich does, without Rich's control characters."""
        for text, style, control in super().render(renderable, options):
            yield Segment(text if control else displayed(text), style, control)


def changing_line(terminal: Terminal, hz: float) -> Live:
    """Return a line on the terminal that is redrawn `hz` times a second and removed at its end."""
    return Live(console=terminal, refresh_per_second=hz, transient=True, redirect_stdout=False, redirect_stderr=False)
