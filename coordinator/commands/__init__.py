"""The commands of `heavylift`, a file per subject; a file that is imported here adds its commands to `app`.

running, resuming, replaying, devs     runs of scenes and models, again, and to their end
operating, watching, hosts             what is said to a run that goes on; who looks at it; other hosts
starting, gallery, health, trusting    a beginning: new, gallery, schema, doctor, trust
scenes, files, tracing, trading        scenes that are not run; recordings; where time went; speed against accuracy
common                                 the application, help, completion, exit codes
"""

from heavylift.coordinator.commands.common.app import app

from . import (
    devs,
    files,
    hosts,
    operating,
    replaying,
    resuming,
    running,
    scenes,
    starting,
    tracing,
    trading,
    trusting,
    watching,
)

__all__ = [
    "app",
    "devs",
    "files",
    "hosts",
    "operating",
    "replaying",
    "resuming",
    "running",
    "scenes",
    "starting",
    "tracing",
    "trading",
    "trusting",
    "watching",
]
