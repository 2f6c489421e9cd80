"""What all commands of `heavylift` share.

app          the command line as a whole; how help looks
options      arguments and options that several commands have
completing   what a shell may complete
process_count       how many processes are worth starting
ending       exit codes, and one sentence where something is wrong
"""

from heavylift.kernel.on_demand import face

face(__name__)
