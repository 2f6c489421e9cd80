"""The commands of `heavylift`: one file per subject registers them at `app`; headings of the help are in `common.app`.

scenes, gallery        scenes without a run: check, statics, modes, equations, tradeoff, new, gallery, ...
running, operating     run, branch, resume; watch a run in progress and give orders to it
replicating            runs of yard files, and of scenes for many seeds
files, replaying       commands about recordings; replay, comparison with a real lift, uncertain inputs
sweeping               many runs of one scene; limits of its numbers; the shortest timing
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
