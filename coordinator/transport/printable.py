"""What others have written, as it may be printed: nothing of it steers a terminal or looks like a line of ours."""


def printable(text: str, longest: int = 0, keep: str = "") -> str:
    """The text with control characters, line ends and changes of direction as escapes, except those to `keep`."""
    shown = "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode() for c in text)
    return f"{shown[:longest]}..." if 0 < longest < len(shown) else shown
