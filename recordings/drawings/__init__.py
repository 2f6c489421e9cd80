"""Dimensioned drawings of a lift's key stages."""


def drawings(rec, verdict, project):
    return []
