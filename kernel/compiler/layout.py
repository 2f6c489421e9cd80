"""Named parts of one block of doubles: the same names index it from Python and from traced text."""

from __future__ import annotations

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np

from .symbol import is_sym, node

Places = Mapping[str, Any]  # name -> index of a scalar, slice of several numbers
Parts = TypeVar("Parts", bound=SimpleNamespace)


class Layout:
    """`sizes`: None = a scalar, n = n numbers; names in `vectors` are unpacked as one vector symbol."""

    def __init__(self, sizes: Mapping[str, int | None], vectors: frozenset[str] = frozenset()) -> None:
        places: dict[str, Any] = {}
        self.vectors = vectors
        n = 0
        for name, m in sizes.items():
            places[name] = n if m is None else slice(n, n + m)
            n += 1 if m is None else m
        self.at: Places = places
        self.size = n

    def unpack(self, block: Any, kind: type[Parts]) -> Parts:
        """Parts of a block by name: scalars, arrays, and the vectors as one value; `kind`: which names there are."""
        if isinstance(block, np.ndarray) and block.dtype == np.float64:
            return kind(**{name: block[at] for name, at in self.at.items()})

        def part(name: str) -> Any:
            x = block[self.at[name]]
            if name in self.vectors and len(x) and is_sym(x[0]):
                return node("slice", x[0].args[0], x[0].args[1], width=len(x))
            return x

        return kind(**{name: part(name) for name in self.at})

    def pack(self, parts: SimpleNamespace) -> list[Any]:
        """The block's values in order (a vector symbol stays one value)."""
        out: list[Any] = []
        for name in self.at:
            x = getattr(parts, name)
            out += x.ravel().tolist() if isinstance(x, np.ndarray) else x if isinstance(x, list) else [x]
        return out
