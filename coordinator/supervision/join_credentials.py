"""The ticket of a process that somebody else starts, as a file that only the user of the run can read.

NAME.ticket stands in the folder where the run was started, whole or not at all, and goes when the run is over.  What a
killed run has left is replaced; a file that is no ticket, or that of a run in progress, stays.
"""

import os
import secrets
from pathlib import Path

import msgspec
from heavylift.coordinator.transport.session import Ticket
from heavylift.kernel.errors import UNREADABLE, OutputError


class TicketFile:
    """The file `NAME.ticket` of a process."""

    def __init__(self, process: str) -> None:
        self.path = Path.cwd() / f"{process}.ticket"
        self._ours = False

    def write(self, ticket: Ticket) -> None:
        """Write it, or that of the next incarnation in its place; OutputError if something else stands there."""
        fresh = self.path.with_name(f".{self.path.name}-{secrets.token_hex(4)}")
        try:
            with open(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
                file.write(ticket.to_text())
            if self._ours or _abandoned(self.path):
                os.replace(fresh, self.path)
            else:
                os.link(fresh, self.path)
            self._ours = True
        except FileExistsError:
            told = "stands there already, and is no ticket of a run that has ended; move it, or run in another folder"
            raise OutputError(f"{self.path} {told}") from None
        except OSError as error:
            raise OutputError(f"{self.path}: a ticket cannot be written there ({error.strerror})") from None
        finally:
            fresh.unlink(missing_ok=True)

    def remove(self) -> None:
        """Nobody may join any more."""
        if self._ours:
            self.path.unlink(missing_ok=True)
            self._ours = False


def _abandoned(path: Path) -> bool:
    """Whether this is the ticket of a run that is not there any more."""
    try:
        return not Path(msgspec.json.decode(path.read_bytes(), type=Ticket).socket).exists()
    except (OSError, *UNREADABLE):
        return False
