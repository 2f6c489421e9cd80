"""The workbench: a scene in a browser beside any editor, drawn and checked anew with each save.

workbench(place)   what `heavylift workbench` does: serves one page on 127.0.0.1 until it is stopped

server             the web routes, and the refusal of requests without the secret word
open_scene         the open scene: watched files, messages to pages
preview            start pose, static path and checks of a scene's text, as messages
picture            states of the static path as the page draws them, in 3D and as drawings
handles            parts of a scene that can be moved by hand, and where the text gives their positions
runs               runs, studies and orders of the open scene, each a process
results            recordings in the folder: verdicts, data to play back, documents to keep
editing            changes of a scene file that check its version and keep comments and order
"""

from heavylift.kernel.on_demand import face

face(__name__)
