"""A self-contained page of a bundle in `page/`: its markup, style and script, with data in a JSON element.

The page's own policy lets no script run but its own, named by its hash, and nothing be fetched that is not named.
"""

from __future__ import annotations

import base64
import hashlib
import re
from pathlib import Path
from typing import Any

import msgspec

from .content import inert

__all__ = ["bundled"]

PAGE = Path(__file__).parents[1] / "page"


def bundled(name: str, content: Any, policy: str = "") -> str:
    """The page `name` that shows this content; `policy`: what its Content-Security-Policy allows beyond itself."""
    script = (PAGE / f"{name}.js").read_text().replace("</script", "<\\/script")
    sha256 = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    parts = {
        "style": (PAGE / f"{name}.css").read_text(),
        "run": inert(msgspec.json.encode(content).decode()),
        "script": script,
        "policy": f"default-src 'none'; script-src 'sha256-{sha256}'; style-src 'unsafe-inline'{policy}",
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda place: parts[place[1]], (PAGE / f"{name}.html").read_text())
