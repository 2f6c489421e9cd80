"""Sheets: one form for everything with tables that people read, and a printer for each file type.

sheet     the sheet: a title, a state, and tables, charts and notes in reading order; the sheet as text
workbook  its tables as .xlsx; the sheet into a file, in the form given by the file ending
"""

from heavylift.kernel.on_demand import face

face(__name__)
