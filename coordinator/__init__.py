"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

Lowest layer first
    protocol, transport     the decisions, without input or output; framed messages over Zenoh
    participants, hosts     what nodes are made of; processes on other hosts
    supervision             start, watch, replace, end processes
    live                    a run while it runs: observers, an operator's orders
    verdict, record         what was found in a run; what it puts on record
    replay, run             a recording runs again; one run
    trace, tradeoff         where the time of a run went; speed against accuracy, measured
    measured                a run beside the log of a real crane
    commands, cli           the command `heavylift`; reference: writes REFERENCE.md; stopping: by signals
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from heavylift.coordinator.run.models import ModelRun, run_models

__all__ = ["ModelRun", "run_models"]


def __getattr__(name: str) -> Any:
    """The public names on demand: node processes import this package and need none of them."""
    if name in __all__:
        from heavylift.coordinator.run import models

        return getattr(models, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
