"""What a lift must not exceed, and the findings of those who looked: `check` on the path, `run` on what happened.

Finding   one thing that was found, with its place, time, value and limit
Verdict   all findings of a scene or a run; red if one of them is
"""

from .findings import Finding, Verdict

__all__ = ["Finding", "Verdict"]
