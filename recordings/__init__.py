"""Recordings: one MCAP file per run, written live, read by any MCAP reader.

A run:      with Recorder("run.mcap", {"scene": "lift", "seed": 1}) as rec: rec.add_port(...); rec.event(...)
Numbers:    rec.layout(SampleLayout([...])); rec.samples(batch)
Reading:    Recording("run.mcap")["rope/tension"], ["legs/1"].tension, .events(), .run, .result: READING.md
For people: info("run.mcap") is a text, plot("run.mcap", "run.png") a figure, storyboard(...) pictures of the lift;
            curves("run.mcap", ["rope/tension/*"], "run.html") any signals, overlay(a, b, out) those of two runs.
A page:     view("run.mcap", "run.html") shows the lift in 3D with signals, stages and events.
A document: report("run.mcap", "report.html") has verdict, checks, loads, stages and dimensioned drawings;
            .pdf on A4, .xlsx, .json, .txt; the drawings alone as .dxf.
Two runs:   compare("a.mcap", "b.mcap") finds their first difference; recover("run.mcap.part") saves a killed run.
Elsewhere:  export("run.mcap", "run.csv", ["rope/tension/*"])
Equal runs: Digest().hexdigest() is equal for equal runs.
"""

from typing import TYPE_CHECKING

from heavylift.kernel.on_demand import on_demand

if TYPE_CHECKING:
    from heavylift.recordings.documents import report
    from heavylift.recordings.format.digest import Digest
    from heavylift.recordings.format.samples import SampleChannel, SampleLayout
    from heavylift.recordings.format.schema import RecordedEvent
    from heavylift.recordings.format.viewer_messages import DrawnBox, RopeLine
    from heavylift.recordings.read.container import FileChannel
    from heavylift.recordings.read.export import export
    from heavylift.recordings.read.reader import Recording
    from heavylift.recordings.read.recover import Recovered, recover
    from heavylift.recordings.read.signal import RecordedPart, Signal
    from heavylift.recordings.read.verdict import info, info_data
    from heavylift.recordings.render.compare import Difference, RecordingComparison, compare, overlay
    from heavylift.recordings.render.curves import curves
    from heavylift.recordings.render.plot import plot
    from heavylift.recordings.render.storyboard import storyboard
    from heavylift.recordings.render.view import view
    from heavylift.recordings.write.broadcast import Spectator
    from heavylift.recordings.write.outputs import file_path
    from heavylift.recordings.write.sink import Peak
    from heavylift.recordings.write.writer import Recorder

__all__ = [
    "Difference", "Digest", "DrawnBox", "FileChannel", "Peak", "RecordedEvent", "RecordedPart", "Recorder", "Recording",
    "RecordingComparison", "Recovered", "RopeLine", "SampleChannel", "SampleLayout", "Signal", "Spectator", "compare",
    "curves", "export", "file_path", "info", "info_data", "overlay", "plot", "recover", "report", "storyboard", "view",
]  # fmt: skip
__getattr__ = on_demand(__name__)
