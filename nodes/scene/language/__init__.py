"""The language of the action list.

phrases      what is written to the right of `target:`, `when:`, ...
quantities   what conditions measure
grammar      reads it, by words
"""
