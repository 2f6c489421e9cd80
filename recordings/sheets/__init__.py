"""One document for all that people read in tables: a sheet, and a printer for each form.

sheet     the sheet: a title, a state, and tables, charts and notes in the order in which they are read
terminal  the sheet as text
page      the sheet as self-contained HTML
workbook  its tables as .xlsx
browser   a page as PDF, by a browser
figures   figures in the colours of the page
writing   the sheet into a file, in the form that the ending asks for
"""

from heavylift.kernel.on_demand import face

face(__name__)
