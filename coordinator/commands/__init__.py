"""The commands of `heavylift`, a file per subject; a file that is imported here adds its commands to `app`.

scenes, gallery        scenes that are not run: check, statics, modes, equations, tradeoff, new, gallery, ...
running, operating     runs: run, resume; what is said to a run that goes on, and who looks at it
files, replaying       recordings; measuring: beside a real lift, uncertain inputs
sweeping, limiting     many runs of one scene; how far its numbers may go
branching              a recorded run, otherwise from some time on
own_models, hosts      devs, trust; several hosts
health                 doctor
common                 the application, help, completion, exit codes
"""

from heavylift.coordinator.commands.common.app import app

from . import (
    branching,
    files,
    health,
    hosts,
    limiting,
    measuring,
    operating,
    own_models,
    replaying,
    running,
    scenes,
    sweeping,
)

__all__ = [
    "app", "branching", "files", "health", "hosts", "limiting", "measuring", "operating", "own_models",
    "replaying", "running", "scenes", "sweeping",
]  # fmt: skip
