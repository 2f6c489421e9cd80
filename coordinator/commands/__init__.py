"""The commands of `heavylift`, a file per subject, which adds them to `app`; each has its heading in `common.app`.

scenes, gallery        scenes that are not run: check, statics, modes, equations, tradeoff, new, gallery, ...
running, operating     runs: run, branch, resume; what is said to a run that goes on, and who looks at it
files, replaying       recordings; measuring: beside a real lift, uncertain inputs
sweeping               many runs of one scene; how far its numbers may go
own_models, hosts      devs, trust; several hosts
health                 doctor
common                 the application, help, completion, exit codes
"""

from importlib import import_module

from heavylift.coordinator.commands.common.app import HEADINGS, app
from heavylift.kernel.on_demand import face

__all__ = ["app"]
for subject in HEADINGS:
    import_module(f"{__name__}.{subject}")

face(__name__)
