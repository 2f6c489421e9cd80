"""Recordings: one MCAP file per run, written live, read by any MCAP reader.

A run:      with Recorder("run.mcap", {"scene": "lift", "seed": 1}) as rec: rec.add_port(...); rec.event(...)
Numbers:    rec.layout(SampleLayout([...])); rec.samples(batch)
Reading:    Recording("run.mcap").signal("rope/tension"), .events(), .run, .result
For people: info("run.mcap") is a text, plot("run.mcap", "run.png") a figure, storyboard(...) the lift itself.
Equal runs: Digest().hexdigest() is one line that two equal runs share.
"""

from .digest import Digest
from .drawing import Box, RopeLine
from .info import info
from .plot import plot
from .reader import RecordedEvent, Recording, Signal, Topic
from .rows import Peak
from .samples import SampleChannel, SampleLayout
from .storyboard import storyboard
from .writer import Recorder

__all__ = [
    "Box",
    "Digest",
    "Peak",
    "RecordedEvent",
    "Recorder",
    "Recording",
    "RopeLine",
    "SampleChannel",
    "SampleLayout",
    "Signal",
    "Topic",
    "info",
    "plot",
    "storyboard",
]
