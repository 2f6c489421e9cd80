"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

core        the protocol's decisions, without IO                node, memory        the node's side; both in one loop
hub, link   Zenoh sessions, framed and checked                  processes, keeper   the node processes of a run
conversation, joining, tape     any run                         run, record         the run of a scene
model_run   `run_models`: any DEVS model, child by child        cli                 the command `heavylift`
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .model_run import ModelRun, run_models

__all__ = ["ModelRun", "run_models"]


def __getattr__(name: str) -> Any:
    """The public names on demand: node processes import this package and need none of them."""
    if name in __all__:
        from . import model_run

        return getattr(model_run, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
