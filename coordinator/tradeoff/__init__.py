"""The trade between speed and accuracy of a scene: measured, and told on one page.

    measured = measure(load("lift"), ("rope tension",), limit=0.01, budget=300.0)
    write(measured, "lift.html")          or .png, .svg, .csv, .json

settings     rungs x methods x steps or tolerances that a scene can be run with
playing      one run of a setting in this process, cut when it takes too long
quantities   what a scene can be asked, and how far two runs are apart in it
planning     which run is next, and whether it fits into the budget
measuring    the reference, its own convergence, then all settings
verdict      which setting to use, and the next faster one that fails; for each quantity alone
figure, page, files   what is written
communication         what processes would cost a scene
"""

from heavylift.kernel.on_demand import face

from .files import write
from .measuring import Measured, measure

__all__ = ["Measured", "measure", "write"]

face(__name__)
