"""What all commands of `heavylift` share.

app          the command line as a whole; form of the help; exit codes; an error as one sentence
options      arguments and options of several commands; shell completion
process_count       the fastest number of processes on this machine
"""

from heavylift.kernel.on_demand import face

face(__name__)
