"""Sheets: one form for all documents with tables, and a printer for each file type.

sheet     the sheet: a title, a state, and tables, charts and notes in reading order; the sheet as text
workbook  the tables of a sheet as .xlsx; a sheet as a file, in the format that the file ending names
"""

from heavylift.kernel.on_demand import face

face(__name__)
