"""Recordings: one MCAP file per run, written live, read by any MCAP reader.

A run:      with Recorder("run.mcap", {"scene": "lift", "seed": 1}) as rec: rec.add_port(...); rec.event(...)
Numbers:    rec.layout(SampleLayout([...])); rec.samples(batch)
Reading:    Recording("run.mcap")["rope/tension"], ["loader/1"].tension, .events(), .run, .result: READING.md
For people: info("run.mcap") is a text, plot("run.mcap", "run.png") a figure, storyboard(...) the lift itself;
            curves("run.mcap", ["rope/tension/*"], "run.html") any signals, overlay(a, b, out) those of two runs.
A page:     view("run.mcap", "run.html") shows the lift in 3D with signals, stages and events.
A document: report("run.mcap", "report.html") tells what each stage asked of ropes and cranes.
Two runs:   compare("a.mcap", "b.mcap") tells where they part; recover("run.mcap.part") saves what a killed run left.
Elsewhere:  export("run.mcap", "run.csv", ["rope/tension/*"])
Equal runs: Digest().hexdigest() is one line that two equal runs share.
"""

from .compare import Comparison, Difference, compare, overlay
from .curves import curves
from .digest import Digest
from .drawing import Box, RopeLine
from .export import export
from .info import info, info_data
from .outputs import file_path
from .part import Part
from .plot import plot
from .reader import RecordedEvent, Recording, Topic
from .recover import Recovered, recover
from .report import report
from .rows import Peak
from .samples import SampleChannel, SampleLayout
from .signal import Signal
from .spectator import Spectator
from .storyboard import storyboard
from .view import view
from .writer import Recorder

__all__ = [
    "Box",
    "Comparison",
    "Difference",
    "Digest",
    "Part",
    "Peak",
    "RecordedEvent",
    "Recorder",
    "Recording",
    "Recovered",
    "RopeLine",
    "SampleChannel",
    "SampleLayout",
    "Signal",
    "Spectator",
    "Topic",
    "compare",
    "curves",
    "export",
    "file_path",
    "info",
    "info_data",
    "overlay",
    "plot",
    "recover",
    "report",
    "storyboard",
    "view",
]
