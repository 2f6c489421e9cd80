"""What all commands of `heavylift` share.

app          the command line as a whole; arguments and options
completing   what a shell may complete
paying       how many processes are worth starting
helping      how help looks
ending       exit codes, and one sentence where something is wrong
"""
