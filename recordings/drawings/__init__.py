"""Dimensioned drawings of a lift's key instants, for a report and as DXF.

sheets    a drawing: views and title block on a sheet of A4, as SVG and as DXF
views     plan, elevation and rigging sketch with their dimensions
instants  choice of the instants, and positions of all bodies and ropes in each
ink       lines, texts and dimensions on paper
"""

from heavylift.kernel.on_demand import face

from .sheets import drawings, write_dxf

__all__ = ["drawings", "write_dxf"]

face(__name__)
