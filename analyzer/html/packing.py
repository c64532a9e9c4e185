"""Columns of numbers as text: little-endian, base64, with their type before them (`H:AAEC...`).

Rules: CNF-25. Nothing is compressed: what a compressor writes depends on its version, and a page must not.
"""

from __future__ import annotations

import sys
from array import array
from base64 import b64encode
from collections.abc import Iterable
from typing import Any, Final

# array's letters; `data.js` reads the same.
TYPES: Final = "BhHiIfd"


def packed(type: str, numbers: Iterable[Any]) -> str:
    """A column. Rules: CNF-25. `type`: one of TYPES."""
    column = numbers if isinstance(numbers, array) and numbers.typecode == type else array(type, numbers)
    if sys.byteorder == "big":
        column = array(type, column)
        column.byteswap()
    return f"{type}:{b64encode(column.tobytes()).decode()}"
