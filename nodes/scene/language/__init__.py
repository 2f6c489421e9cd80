"""The language of the action list.

phrases   what is written to the right of `target:`, `when:`, ...
grammar   reads it
"""
