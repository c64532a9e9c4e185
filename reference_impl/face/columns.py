"""Many frames as columns of machine numbers, for formats that hold whole sequences.

Rules: CNF-1, CNF-25, FBA-34.

Rows of equal length stand one after the other; a set flag (one byte) tells null from 0.
"""

from __future__ import annotations

import struct
from array import array
from typing import Final, final

from .decoded import EXPRESSION_KEYS, VISEME_KEYS
from .frames import FaceFrame

FAPS: Final = 68
_VALUES: Final = struct.Struct(f"{FAPS}q")
_NO_VISEME: Final = array("q", [0] * len(VISEME_KEYS))
_NO_EXPRESSION: Final = array("q", [0] * len(EXPRESSION_KEYS))


@final
class FaceColumns:
    """The columns of decoded frames, as docs/formats.md names them.

    Rules: CNF-1, CNF-25, FBA-34. 64-bit: `time` (2 per row), `faps` (68), `viseme` (4), `expression` (6). One byte:
    `intra`, `faps_set` (68), `viseme_set`, `expression_set`, `state` (68 letters), and `gender`, `coding_type`,
    `fap_quant` with -1 for null. `baps`: row -> BAPs.
    """

    __slots__ = (
        "_flags", "_unset", "baps", "coding_type", "expression", "expression_set", "fap_quant", "faps", "faps_set",
        "gender", "intra", "rows", "state", "time", "viseme", "viseme_set",
    )  # fmt: skip

    def __init__(self) -> None:
        self.rows = 0
        self.time = array("q")
        self.faps = bytearray()
        self.viseme = array("q")
        self.expression = array("q")
        self.gender = array("b")
        self.coding_type = array("b")
        self.fap_quant = array("b")
        self.intra = bytearray()
        self.faps_set = bytearray()
        self.viseme_set = bytearray()
        self.expression_set = bytearray()
        self.state = bytearray()
        self.baps: dict[int, dict[int, int]] = {}
        # Which values of the last row were None, and its set flags: those of the next row are mostly the same.
        self._unset: list[int] = []
        self._flags = b"\1" * FAPS

    def add(self, frame: FaceFrame) -> None:
        """Append one frame. Rules: CNF-1. Raises OverflowError for more than 64 bits, and appends nothing then."""
        # Exact times need more bits with every change of the rate.
        time = array("q", frame.time)
        self.faps += self._packed(frame.faps)
        self.faps_set += self._flags
        self.time.extend(time)
        self.intra.append(frame.intra)
        viseme = frame.viseme
        self.viseme.extend(_NO_VISEME if viseme is None else viseme)
        self.viseme_set.append(viseme is not None)
        expression = frame.expression
        self.expression.extend(_NO_EXPRESSION if expression is None else expression)
        self.expression_set.append(expression is not None)
        self.state += frame.state.encode("ascii")
        self.gender.append(-1 if frame.gender is None else frame.gender)
        self.coding_type.append(-1 if frame.coding_type is None else frame.coding_type)
        self.fap_quant.append(-1 if frame.fap_quant is None else frame.fap_quant)
        if frame.baps is not None:
            self.baps[self.rows] = frame.baps
        self.rows += 1

    def _packed(self, faps: tuple[int | None, ...]) -> bytes:
        values = list(faps)
        as_before = True
        for i in self._unset:
            if values[i] is not None:
                as_before = False
                break
            values[i] = 0
        if as_before:
            try:
                # Refuses None, so that no other value than those is unset.
                return _VALUES.pack(*values)
            except struct.error:
                pass
        flags = bytes([value is not None for value in faps])
        try:
            packed = _VALUES.pack(*[0 if value is None else value for value in faps])
        except struct.error:
            raise OverflowError("a value of more than 64 bits") from None
        self._unset = [i for i, value in enumerate(faps) if value is None]
        self._flags = flags
        return packed
