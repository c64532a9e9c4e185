"""What stands between objects and planes of any kind: stuffing to the next byte, and user data.

Rules: FBA-3 (stuffing), SYS-5 (user data), CNF-22.
"""

from __future__ import annotations

from typing import Final

from ..bitstream.errors import ForbiddenValue, ResourceLimit
from ..bitstream.startcodes import USER_DATA
from .base import SyntaxIO
from .element import Element, Fault

STUFFING: Final = Element("stuffing", "FBA-3", fixed=True)
USER_DATA_START_CODE: Final = Element("user_data_start_code", "SYS-5", fixed=True)
USER_DATA_BYTES: Final = Element("user_data", "SYS-5")

_WRONG_STUFFING: Final = Fault(ForbiddenValue, "FBA-3", "stuffing", "")
_USER_DATA_LIMIT: Final = Fault(ResourceLimit, "CNF-22", "user_data", "")


def stuffing(io: SyntaxIO) -> None:
    """A 0 bit, then 1 bits up to the next byte; a whole byte where none is begun. Rules: FBA-3."""
    start = io.tell()
    width = 8 - (start & 7)
    right = (1 << (width - 1)) - 1
    read = io.u(STUFFING, width, right)
    io.require(read == right, _WRONG_STUFFING.allowing(f"{right:0{width}b}"), f"{read:0{width}b}", start, io.tell())


def user_data(io: SyntaxIO, data: bytes) -> bytes:
    """User data with its start code: all bytes up to the next start code prefix. Rules: SYS-5, CNF-22.

    `data`: what a writer writes.
    """
    start = io.tell()
    io.u(USER_DATA_START_CODE, 32, USER_DATA)
    count = io.bytes_to_prefix(len(data))
    if count > io.limits.user_data_bytes:
        fault = _USER_DATA_LIMIT.allowing(f"at most {io.limits.user_data_bytes} bytes")
        io.require(False, fault, count, start, io.tell() + 8 * count)
    return io.raw(USER_DATA_BYTES, count, data)
