"""The text of a scene.

source, files   the text with the place of every key and value; how files are read
overlay         scenes that extend others, settings of the command line
faults          every error, with file, line and column
units           quantities with units, and the pydantic types that read them
"""
