"""Sheets: one form for everything with tables that people read, and a printer for each file type.

sheet     the sheet: a title, a state, and tables, charts and notes in reading order
terminal  the sheet as text
page      the sheet as self-contained HTML
workbook  its tables as .xlsx
browser   a page as PDF, by a browser
figures   figures in the colours of the page
writing   the sheet into a file, in the form given by the file ending
"""

from heavylift.kernel.on_demand import face

face(__name__)
