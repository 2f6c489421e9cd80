"""Findings of the checks of a scene's physics, reported once per subject and without repeated sentences.

A check yields (subject, where, sentence). If several subjects have the same fault at the same place, the first is
reported in full and the others are named.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

Violations: TypeAlias = Iterator[tuple[str, str, str]]


@dataclass
class Findings:
    """Findings of many checks over many states, in order of occurrence."""

    seen: set[tuple[str, str]] = field(default_factory=set)
    sentences: dict[tuple[str, str, str], str] = field(default_factory=dict)
    others: dict[tuple[str, str, str], list[str]] = field(default_factory=dict)

    def take(self, check: str, violations: Violations, stage: str = "", where: str = "") -> None:
        """Add the violations of a check; `where` of the causing action replaces that of the thing."""
        for subject, place, sentence in violations:
            if (check, subject) in self.seen:
                continue
            self.seen.add((check, subject))
            key = (check, where or place, stage)
            if where and key in self.sentences:
                self.others.setdefault(key, []).append(subject)
            else:
                self.sentences.setdefault(key, sentence)

    def list(self) -> list[tuple[str, str]]:
        """Return (where, sentence) of each finding."""
        found = []
        for key, sentence in self.sentences.items():
            _, where, stage = key
            likewise = f"; likewise {', '.join(self.others[key])}" if key in self.others else ""
            found.append((where, sentence + likewise + (f" ({stage})" if stage else "")))
        return found
