"""The workbench: a scene in a browser beside any editor, drawn and checked anew with each save.

workbench(place)   what `heavylift workbench` does: serves one page on 127.0.0.1 until it is stopped

server             the routes behind the word in the address; who is refused
open_scene         the open scene: its files watched, what pages are shown
preview            from the text of a scene to start pose, path at rest and checks, as messages
picture            states of the path at rest as the page draws them, in 3D and as drawings
handles            what of a scene can be moved by hand, and where its place is written
runs               runs, studies and orders of the open scene, each a process
results            what is recorded in the folder: verdicts, what the page plays of them, documents to keep
editing            changes of a scene file: version checked, comments and order kept, written whole
"""

from heavylift.kernel.on_demand import face

face(__name__)
