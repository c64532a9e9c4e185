"""Planes: mutable records of exactly what the wire says.

Rules: FBA-5, FBA-9..13, FBA-28, FBA-40, FBA-43.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

from ..syntax.base import PLANE, STUFFED_CODE
from ..syntax.temporal import TemporalHeader
from .dct_syntax import SegmentData
from .frames import FaceFrame


@final
class ParameterData:
    """FAP or BAP data of one plane.

    Rules: FBA-9..13, FBA-16, FBA-28, FBA-40.

    Intra planes only: `quant`, `mask_type` and `group_mask` per group (the mask as the number that was sent: first
    bit = most significant), `gender`, `coding_type`, `new` (the four flags i_max, i_min, p_max, p_min) and `limits`
    (per list, by parameter number, the 5-bit v; only selected parameters count; empty where no list was sent).
    Every plane: `levels` (of the selected parameters in coding order; FAPs: 3..68), and for FAP 1 `viseme` (3 levels)
    and `viseme_def`, for FAP 2 `expression` (4 levels), `init_face`, `expression_def`. With coding type 1 `segment`
    instead. `tails`: how the last two data bits of the viseme, expression and FAP or BAP segment differ from an
    encoder's, 0 for all that encoders make.
    """

    __slots__ = (
        "coding_type", "expression", "expression_def", "gender", "group_mask", "init_face", "levels", "limits",
        "mask_type", "new", "quant", "segment", "tails", "viseme", "viseme_def",
    )  # fmt: skip

    def __init__(self, groups: int) -> None:
        self.quant = 0
        self.mask_type = [0] * groups
        self.group_mask = [0] * groups
        self.gender = 0
        self.coding_type = 0
        self.new = [0, 0, 0, 0]
        self.limits: list[list[int]] = []
        self.levels: list[int] = []
        self.viseme: list[int] = [0, 0, 0]
        self.viseme_def = 0
        self.expression: list[int] = [0, 0, 0, 0]
        self.init_face = 0
        self.expression_def = 0
        self.segment: SegmentData | None = None
        self.tails = [0, 0, 0]


@final
class FbaPlane:
    """One `fba_object_plane()`.

    Rules: FBA-2, FBA-5, FBA-43.

    `boundary`: what stands before it (PLANE, STUFFED_CODE, BARE_CODE of `syntax.base`); `start_code`: the code, 0 for
    none. `faps`, `baps`: present where the bits of `fba_object_mask` say so. `frames`: what it decodes to. `start`,
    `end`: its bits, start code and stuffing before it not counted.
    """

    __slots__ = (
        "baps", "boundary", "end", "faps", "fba_object_mask", "frames", "header", "is_intra", "start", "start_code",
    )  # fmt: skip

    def __init__(self) -> None:
        self.boundary = PLANE
        self.start_code = 0
        self.is_intra = 0
        self.fba_object_mask = 0
        self.header = TemporalHeader()
        self.faps: ParameterData | None = None
        self.baps: ParameterData | None = None
        self.frames: list[FaceFrame] = []
        self.start = 0
        self.end = 0


@final
class FbaObject:
    """An `fba_object()` without its planes.

    Rules: FBA-1, FBA-3, FBA-42.

    `start_code`: 0x1BA, or the draft's. `end`: what ends it (STUFFED_CODE: another start code follows; STUFFED_END,
    END, ZERO_PADDING); `padding`: the zero bits of ZERO_PADDING. `coming`: where a writer takes the planes from, one
    by one, instead of `planes`.
    """

    __slots__ = ("coming", "end", "padding", "planes", "start_code")

    def __init__(self) -> None:
        self.start_code = 0x000001BA
        self.end = STUFFED_CODE
        self.padding = 0
        self.planes: list[FbaPlane] = []
        self.coming: Iterator[FbaPlane] | None = None
