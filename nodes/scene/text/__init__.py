"""The text of a scene.

source, files   the text with the place of every key and value; how files are read
overlay         scenes that extend others, settings of the command line
faults          every error, with file, line and column
units           quantities with units, and the pydantic types that read them
uncertainty     how uncertain a number is: `480 t +- 3 %`, `460..500 t`, `480 t sd 5 t`
"""
