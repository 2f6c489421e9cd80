"""Hook of mkdocs: pages and pictures of the rooms under their paths in the repository, so that links work in both.

The reference is made here, from docstrings, help texts and schema.  A source file that a page links to gets a page.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[3]
LINK = re.compile(r"(?<=\]\()([^)#:\s]+)(?=[)#])")
LANGUAGES = {".py": "python", ".rs": "rust", ".yaml": "yaml", ".json": "json", ".ipynb": "json"}
PICTURES = (".png", ".gif", ".svg")


def on_files(files: Files, config: Any) -> Files:
    """Add pages, pictures, the reference, and sources to which pages link."""
    sys.path.insert(0, str(ROOT / "tests/pages"))  # mkdocs restores the path behind its hooks
    from reference import parts

    listed = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", "*.md", "*.png"]
    names = subprocess.run(listed, check=True, capture_output=True, text=True).stdout.splitlines()
    for name in (x for x in names if (ROOT / x).exists() and not x.startswith("tests/")):
        files.append(File(name, str(ROOT), config.site_dir, config.use_directory_urls))
    for name, text in parts().items():
        files.append(File.generated(config, f"reference/{name}.md", content=text))
    linked = {path for x in names if x.endswith(".md") and (ROOT / x).exists() for path in _sources(ROOT / x)}
    for path in sorted(linked):
        name = path.relative_to(ROOT).as_posix()
        code = f"````{LANGUAGES.get(path.suffix, 'text')}\n{path.read_text(encoding='utf-8')}\n````"
        page = f"---\nsearch: {{exclude: true}}\n---\n# {path.name}\n\n`{name}`\n\n{code}\n"
        files.append(File.generated(config, f"{name}.source.md", content=page))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Files) -> str:
    """Let links to sources lead to their pages."""
    here = (ROOT / page.file.src_uri).parent
    return LINK.sub(lambda found: f"{found[1]}.source.md" if _is_source(here / found[1]) else found[1], markdown)


def _sources(page: Path) -> list[Path]:
    text = page.read_text(encoding="utf-8")
    return [(page.parent / x).resolve() for x in LINK.findall(text) if _is_source(page.parent / x)]


def _is_source(path: Path) -> bool:
    return path.is_file() and path.suffix not in (".md", *PICTURES)
