"""What all commands of `heavylift` share.

app          the command line as a whole; how help looks; exit codes, and one sentence where something is wrong
options      arguments and options that several commands have; what a shell may complete
process_count       how many processes are worth starting
"""

from heavylift.kernel.on_demand import face

face(__name__)
