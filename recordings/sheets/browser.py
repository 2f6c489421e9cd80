"""Print a page to PDF with a browser on this machine: Chromium or a relative of it, without a window."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from heavylift.kernel.errors import RecordingError

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
PATIENCE = 60.0  # [s]


def print_page(page: str, out: Path) -> bytes:
    """Print a self-contained page as PDF and return its bytes; raises RecordingError if no browser can do it."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if found is None:
        raise RecordingError(
            f"{out}: no Chromium or Chrome is installed to print it; write {out.with_suffix('.html')} and print that "
            "from any browser"
        )
    with tempfile.TemporaryDirectory(prefix="heavylift-", ignore_cleanup_errors=True) as folder:
        source, printed = Path(folder) / "report.html", Path(folder) / "report.pdf"
        source.write_text(page, encoding="utf-8")
        flags = ["--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer", "--no-sandbox"]  # our page
        target = [f"--user-data-dir={folder}/profile", f"--print-to-pdf={printed}", source.as_uri()]
        try:
            subprocess.run([found, *flags, *target], capture_output=True, timeout=PATIENCE, check=True)
            return printed.read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise RecordingError(
                f"{out}: {Path(found).name} did not print it ({type(error).__name__}); write "
                f"{out.with_suffix('.html')} and print that from any browser"
            ) from None
