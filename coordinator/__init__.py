"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

protocol        the decisions, without input or output      participants    what nodes are made of
transport       framed messages over Zenoh                  hosts           placement, processes elsewhere
supervision     start, watch, replace, end processes        run, record     one run, and what it puts on record
live, trace     a run while it runs; where its time went    replay          a recording runs again
tradeoff        speed against accuracy, measured            cli, commands   the command `heavylift`
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .run.models import ModelRun, run_models

__all__ = ["ModelRun", "run_models"]


def __getattr__(name: str) -> Any:
    """The public names on demand: node processes import this package and need none of them."""
    if name in __all__:
        from .run import models

        return getattr(models, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
