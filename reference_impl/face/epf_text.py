"""`.epf` text: encoder parameters, one block of tagged lines per coded frame.

Rules: FBA-52, with the domains of FBA-5..8, FBA-10, FBA-14, FBA-16, FBA-37, FBA-40; FBA-51 for line ends and
blanks.
Not here: what an encoder does with them (FBA-43).

Definitions of this suite where FBA-52 is silent: `#` lines are comments; group masks are digits, lowest
parameter of the group first, with or without blanks; limits stand in ascending order of the parameter
numbers; SKN and BSK may stand in inter blocks too, as skip_frames does; the limits a file gives are for
fap_quant 1, as FBA-16 has them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from snhc.reference_impl.bitstream.errors import (
    EncodeError,
    ForbiddenValue,
    InconsistentSemantics,
    MarkerBit,
    RangeViolation,
    ResourceLimit,
    SnhcError,
)
from snhc.reference_impl.bitstream.findings import Finding
from snhc.reference_impl.bitstream.limits import DEFAULT_LIMITS, Limits
from snhc.reference_impl.face._text_lines import INT_MAX, TextLines
from snhc.reference_impl.tables import bap_groups, fap_groups

_STEP: Final = 60
_LIMIT_MAX: Final = 31 * _STEP
# For the writer's own lines: what is refused there is refused by rule, not by size.
_UNLIMITED: Final = Limits(skipped_frames=INT_MAX, text_line_bytes=INT_MAX)
_TOKEN: Final = re.compile(rb"[^ \t]+")

# tag -> body?, field of PartParameters, kind, data (needs the bit of fba_object_mask), intra only
_TAGS: Final[dict[str, tuple[bool, str, str, bool, bool]]] = {
    "FFR": (False, "frame", "frame", True, False),
    "FRR": (False, "frame_rate", "rate", False, True),
    "TC": (False, "time_code", "time", False, True),
    "SKN": (False, "skip", "skip", False, False),
    "FMT": (False, "mask_types", "masks", True, True),
    "FQU": (False, "quant", "quant", True, True),
    "FIX": (False, "i_max", "max", True, True),
    "FIN": (False, "i_min", "min", True, True),
    "FPX": (False, "p_max", "max", True, True),
    "FPN": (False, "p_min", "min", True, True),
    "GDR": (False, "gender", "flag", True, True),
    "CDM": (False, "coding_type", "flag", True, True),
    "BFR": (True, "frame", "frame", True, False),
    "BRR": (True, "frame_rate", "rate", False, True),
    "BTC": (True, "time_code", "time", False, True),
    "BSK": (True, "skip", "skip", False, False),
    "BMT": (True, "mask_types", "masks", True, True),
    "BQU": (True, "quant", "quant", True, True),
    "BIX": (True, "i_max", "max", True, True),
    "BIN": (True, "i_min", "min", True, True),
    "BPX": (True, "p_max", "max", True, True),
    "BPN": (True, "p_min", "min", True, True),
}
_FRAME_TAGS: Final = ("FFR", "BFR")


@dataclass(slots=True)
class PartParameters:
    """What one block says about the face, or the body; None where it says nothing.

    Rules: FBA-52.

    `frame`: number of the `.fap` / `.bap` frame the block refers to. `frame_rate`: rate 0..255, seconds 0..15
    (in 1/16), ntsc 0..1. `time_code`: h, m, s (the marker is always 1). `skip`: frames to skip. `mask_types`:
    10 (face) or 24 (body); `masks`: as many, the digits of the group in the order of its table where the type
    is 1 or 2, else (). `quant`: 0..31. `i_max`, `i_min`, `p_max`, `p_min`: 66 (FAP 3..68), or 296 or 186 (BAP
    1..), multiples of 60 within -1860..1860. `gender`: 1 male; `coding_type`: 1 DCT; face only.
    """

    frame: int | None = None
    frame_rate: tuple[int, int, int] | None = None
    time_code: tuple[int, int, int] | None = None
    skip: int | None = None
    mask_types: tuple[int, ...] | None = None
    masks: tuple[tuple[int, ...], ...] | None = None
    quant: int | None = None
    i_max: tuple[int, ...] | None = None
    i_min: tuple[int, ...] | None = None
    p_max: tuple[int, ...] | None = None
    p_min: tuple[int, ...] | None = None
    gender: int | None = None
    coding_type: int | None = None


@dataclass(slots=True)
class CodedFrame:
    """One block.

    Rules: FBA-52. `fba_object_mask`: 0..3 (1 face, 2 body). `is_intra`: None where the block does not say.
    `line`: of its FBM, 0 if not read; not compared.
    """

    fba_object_mask: int
    is_intra: bool | None = None
    face: PartParameters = field(default_factory=PartParameters)
    body: PartParameters = field(default_factory=PartParameters)
    line: int = field(default=0, compare=False)


@dataclass(slots=True)
class EncoderParameters:
    """A whole `.epf` text: its blocks in order. Rules: FBA-52. `findings`: dialects met; not compared."""

    frames: list[CodedFrame] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list, compare=False)


class EpfReader:
    """Reads an `.epf` text block by block.

    Rules: FBA-52, FBA-51, CNF-22, CNF-25.

    Arguments as `FapReader`; iterate for `CodedFrame`. Raises `InputFormat` (unknown tag, number of fields),
    `RangeViolation`, `ForbiddenValue` (rate 0, time code fields, BAP mask type 2), `MarkerBit`,
    `InconsistentSemantics` (order of tags, a tag twice, a tag of a part not coded), `ResourceLimit`, with
    line and column.
    """

    def __init__(self, stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> None:
        self._lines = TextLines(stream, "FBA-52", strict, limits.text_line_bytes)
        self._skip_limit = limits.skipped_frames
        self._tokens: list[bytes] = []
        self._starts: list[int] = []
        self._quant_known = [False, False]
        self._last_frame = [-1, -1]
        self._sizes = ([g.count for g in fap_groups()], [g.count for g in bap_groups()])

    def findings(self) -> list[Finding]:
        """The dialects met so far, one finding per kind. Rules: FBA-51, CNF-23."""
        return self._lines.findings()

    def __iter__(self) -> Iterator[CodedFrame]:
        lines = self._lines
        block: CodedFrame | None = None
        while lines.next_line():
            if lines.is_comment():
                continue
            lines.plain()
            matches = list(_TOKEN.finditer(lines.raw))
            self._tokens = [match.group() for match in matches]
            self._starts = [match.start() for match in matches]
            tag = self._tokens[0]
            if tag == b"FBM":
                if block is not None:
                    yield block
                self._count(1)
                block = CodedFrame(self._int(1, "fba_object_mask", 0, 3), line=lines.number)
            elif tag != b"ISI" and tag.decode("ascii", "replace") not in _TAGS:
                lines.fault(self._starts[0], "tag", tag, "FBM, ISI, " + ", ".join(_TAGS))
            elif block is None:
                self._order("tag before the first FBM")
            elif tag == b"ISI":
                if block.is_intra is not None:
                    self._order("second ISI of the block")
                self._count(1)
                block.is_intra = self._int(1, "is_intra", 0, 1) == 1
            else:
                self._tag(block, tag.decode("ascii"))
        if block is None:
            lines.number = max(lines.number, 1)
            lines.raw = b""
            lines.fault(0, "no coded frame", b"", "FBM n")
        yield block

    def _tag(self, block: CodedFrame, tag: str) -> None:
        body, name, kind, data, intra = _TAGS[tag]
        side = 1 if body else 0
        part = block.body if body else block.face
        if data and not block.fba_object_mask & (2 if body else 1):
            self._order(f"{tag} in a block whose FBM codes no {'body' if body else 'face'}")
        if intra and not block.is_intra:
            self._order(f"{tag} without ISI 1 before it")
        if getattr(part, name) is not None:
            self._order(f"second {tag} of the block")
        value: int | tuple[int, ...]
        if kind == "frame":
            self._count(1)
            value = self._int(1, "frame", 0, INT_MAX)
            if value <= self._last_frame[side]:
                self._order(f"{tag} not above {self._last_frame[side]}", 1)
            self._last_frame[side] = value
        elif kind == "rate":
            self._count(3)
            value = (self._int(1, "rate", 0, 255), self._int(2, "seconds", 0, 15), self._int(3, "ntsc", 0, 1))
            if value[0] == 0 and value[1] == 0:
                self._lines.fault(self._starts[1], "frame rate", b"0", "above 0", ForbiddenValue, rule="FBA-37")
        elif kind == "time":
            self._count(4)
            hours = self._int(1, "time_code_hours", 0, 23, ForbiddenValue, "FBA-7")
            minutes = self._int(2, "time_code_minutes", 0, 59, ForbiddenValue, "FBA-7")
            self._int(3, "marker", 1, 1, MarkerBit, "FBA-7")
            value = (hours, minutes, self._int(4, "time_code_seconds", 0, 59, ForbiddenValue, "FBA-7"))
        elif kind == "skip":
            self._count(1)
            value = self._int(1, "frames to skip", 0, INT_MAX)
            if value > self._skip_limit:
                self._lines.fault(
                    self._starts[1],
                    "frames to skip",
                    self._tokens[1],
                    f"at most {self._skip_limit}",
                    ResourceLimit,
                    rule="CNF-22",
                )
        elif kind == "quant":
            if part.i_max or part.i_min or part.p_max or part.p_min:
                self._order(f"{tag} behind limits")
            self._count(1)
            value = self._int(1, "bap_quant" if body else "fap_quant", 0, 31)
            self._quant_known[side] = True
        elif kind == "flag":
            self._count(1)
            value = self._int(1, name, 0, 1)
        elif kind == "masks":
            value, part.masks = self._masks(side)
        else:
            if not self._quant_known[side]:
                self._order(f"{tag} before any {'BQU' if body else 'FQU'}")
            value = self._limits(side, name, kind == "max")
        setattr(part, name, value)

    def _masks(self, side: int) -> tuple[tuple[int, ...], tuple[tuple[int, ...], ...]]:
        lines = self._lines
        tokens = self._tokens
        sizes = self._sizes[side]
        types: list[int] = []
        masks: list[tuple[int, ...]] = []
        at = 1
        for group, size in enumerate(sizes, 1):
            if at >= len(tokens):
                self._short(f"mask types {group - 1}", len(sizes))
            kind = self._int(at, "bap_mask_type" if side else "fap_mask_type", 0, 3)
            if side and kind == 2:
                lines.fault(self._starts[at], "bap_mask_type", b"2", "0, 1, 3", ForbiddenValue, rule="FBA-40")
            at += 1
            digits: list[int] = []
            while kind in (1, 2) and len(digits) < size:
                if at >= len(tokens):
                    self._short(f"digits of group mask {group} {len(digits)}", size)
                run = tokens[at]
                if run.translate(None, b"01"):
                    lines.fault(self._starts[at], f"mask of group {group}", run, f"{size} digits 0, 1")
                if len(digits) + len(run) > size:
                    lines.fault(
                        self._starts[at],
                        f"digits of group mask {group}",
                        b"%d" % (len(digits) + len(run)),
                        expected=size,
                    )
                digits.extend([byte - 0x30 for byte in run])
                at += 1
            types.append(kind)
            masks.append(tuple(digits))
        if at < len(tokens):
            lines.fault(self._starts[at], "field behind the last group", tokens[at], "end of line")
        return tuple(types), tuple(masks)

    def _limits(self, side: int, name: str, upper: bool) -> tuple[int, ...]:
        counts = (sum(self._sizes[1]), 186) if side else (sum(self._sizes[0][1:]),)
        read = len(self._tokens) - 1
        if read not in counts:
            at = self._starts[max(counts) + 1] if read > max(counts) else len(self._lines.raw.rstrip(b" \t"))
            self._lines.fault(at, f"limits {name}", b"%d" % read, expected=" or ".join(str(n) for n in counts))
        out: list[int] = []
        for i in range(1, len(self._tokens)):
            # Outward, so that no value the file allows is lost.
            if upper:
                out.append(-(-self._int(i, name, 0, _LIMIT_MAX) // _STEP) * _STEP)
            else:
                out.append(self._int(i, name, -_LIMIT_MAX, 0) // _STEP * _STEP)
        return tuple(out)

    def _int(
        self, index: int, what: str, lo: int, hi: int, kind: type[SnhcError] = RangeViolation, rule: str = ""
    ) -> int:
        at = self._starts[index]
        value = self._lines.integer(at, what, self._tokens[index])
        if not lo <= value <= hi:
            allowed = f"{lo}..{hi}" if lo < hi else str(lo)
            self._lines.fault(at, what, self._tokens[index], allowed, kind, rule=rule)
        return value

    def _count(self, fields: int) -> None:
        read = len(self._tokens) - 1
        if read != fields:
            at = self._starts[fields + 1] if read > fields else len(self._lines.raw.rstrip(b" \t"))
            self._lines.fault(at, f"fields of {self._tokens[0].decode('ascii')}", b"%d" % read, expected=fields)

    def _short(self, what: str, expected: int) -> None:
        self._lines.fault(len(self._lines.raw.rstrip(b" \t")), what, b"", expected=expected)

    def _order(self, what: str, index: int = 0) -> None:
        token = self._tokens[index] if index else b""
        allowed = "FBM, then tags of the parts that it codes, each once and behind those that it needs"
        self._lines.fault(self._starts[index], what, token, allowed, InconsistentSemantics)


def read_epf(stream: Iterable[bytes], *, strict: bool = False, limits: Limits = DEFAULT_LIMITS) -> EncoderParameters:
    """Read a whole `.epf` text.

    Rules: FBA-52, FBA-51, CNF-22. Arguments and errors: `EpfReader`; more than `limits.collected_planes`
    blocks are `ResourceLimit`.
    """
    reader = EpfReader(stream, strict=strict, limits=limits)
    frames: list[CodedFrame] = []
    for block in reader:
        if len(frames) >= limits.collected_planes:
            raise ResourceLimit(
                "CNF-22",
                "coded frames kept",
                allowed=f"at most {limits.collected_planes}",
                line=block.line,
                column=1,
            )
        frames.append(block)
    return EncoderParameters(frames, reader.findings())


def _row(tag: str, values: Sequence[int]) -> str:
    return " ".join([tag, *[str(value) for value in values]]) + "\n"


def _part_rows(part: PartParameters, body: bool) -> Iterator[str]:
    for tag, (of_body, name, kind, _, _) in _TAGS.items():
        if of_body != body or tag in _FRAME_TAGS:
            continue
        value = getattr(part, name)
        if value is None:
            continue
        if kind == "masks":
            words = [tag]
            for mask_type, mask in zip(value, part.masks or (), strict=False):
                words.append(str(mask_type))
                if mask:
                    words.append("".join([str(digit) for digit in mask]))
            yield " ".join(words) + "\n"
        elif kind == "time":
            yield _row(tag, (*value[:2], 1, *value[2:]))
        else:
            yield _row(tag, value if isinstance(value, tuple) else (value,))


def _block_text(block: CodedFrame) -> bytes:
    rows = [_row("FBM", (block.fba_object_mask,))]
    for tag, part in (("FFR", block.face), ("BFR", block.body)):
        if part.frame is not None:
            rows.append(_row(tag, (part.frame,)))
    if block.is_intra is not None:
        rows.append(_row("ISI", (int(block.is_intra),)))
    rows.extend(_part_rows(block.face, False))
    rows.extend(_part_rows(block.body, True))
    return "".join(rows).encode("ascii")


def write_epf(parameters: EncoderParameters) -> Iterator[bytes]:
    """The text of encoder parameters, one block per piece; `read_epf` gives the same back.

    Rules: FBA-52. Raises `EncodeError` for what the reader would refuse or give back changed.
    """
    if not parameters.frames:
        raise EncodeError("FBA-52", "no coded frame", allowed="one or more", path="frames")
    texts: list[bytes] = []

    def told() -> Iterator[bytes]:
        for block in parameters.frames:
            texts.append(_block_text(block))
            yield texts[-1]

    # The reader holds the rules of order and range; a second set of checks here could only differ from it.
    blocks = iter(EpfReader(told(), strict=True, limits=_UNLIMITED))
    for i, block in enumerate(parameters.frames):
        path = f"frames[{i}]"
        try:
            back = next(blocks)
        except SnhcError as error:
            raise EncodeError(
                error.rule,
                error.what,
                value=error.value,
                allowed=error.allowed,
                path=path,
                expected=error.expected,
            ) from error
        if back != block:
            raise EncodeError("FBA-52", "parameters that no text holds", allowed="what read_epf can give", path=path)
        yield texts[i]
