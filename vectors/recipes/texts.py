"""Texts of parameters, `.fap` and `.bap`: plain, in the dialects that occur, and with one fault each.

What a text says is told in `vectors/texts.py`. Faults have a line.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

from snhc.reference_impl.bitstream.errors import (
    ForbiddenValue,
    InconsistentSemantics,
    InputFormat,
    RangeViolation,
    ResourceLimit,
    SnhcError,
    Truncated,
)

from ..manifest import BAP, FAP, DecodeOptions
from ..recipe import Accept, Document, Reject, family, vector

FACE_TOOLS: Final = ("fap-text",)
BODY_TOOLS: Final = ("bap-text",)
_HEADER: Final = "2.1 speech 25 2\n"


def _mask(numbers: Collection[int], width: int = 68) -> str:
    return " ".join("1" if i in numbers else "0" for i in range(1, width + 1)) + "\n"


# FAP 3 and 48 in two frames.
_FIRST: Final = _mask((3, 48)) + "0 100 -3400\n"
_SECOND: Final = _mask((3, 48)) + "1 140 -1700\n"
_PLAIN: Final = _HEADER + _FIRST + _SECOND
_VALUES: Final[Mapping[tuple[int, int], int]] = {(0, 3): 100, (0, 48): -3400, (1, 3): 140, (1, 48): -1700}


def _fap(text: str) -> Document:
    return Document(FAP, text.encode())


@vector(id="text.fap.plain", title="Plain .fap text", tier="syntax", tools=FACE_TOOLS, rules=["FBA-50"])
def plain() -> Accept:
    """Comments, the header, two frames: the values of the worked stream, at 25 Hz."""
    return Accept(
        _fap("# made by hand \n#two\n" + _PLAIN), lines=2, values=_VALUES, states={(0, 3): "T", (1, 4): "U"},
        text={1: '"time":"1/25"'}, findings=(),
    )  # fmt: skip


@vector(id="text.fap.high-level", title="Viseme and expression in .fap text", tier="semantic", tools=FACE_TOOLS,
        rules=["FBA-50", "FBA-29"])  # fmt: skip
def high_level() -> Accept:
    """FAP 1 is four integers, FAP 2 six: select1 intensity1 select2 intensity2 init_face expression_def.

    The second frame does not give them: they keep their values, state R.
    """
    text = "2.1 speech 30 2\n" + _mask((1, 2, 3)) + "0 3 14 63 1 6 70 0 -2 1 0 5\n" + _mask((3,)) + "1 6\n"
    line = (
        '"viseme":{"select1":3,"select2":14,"blend":63,"def":1},'
        '"expression":{"select1":6,"intensity1":70,"select2":0,"intensity2":-2,"init_face":1,"def":0}'
    )
    return Accept(
        _fap(text), values={(1, 3): 6}, states={(0, 1): "T", (1, 1): "R", (1, 2): "R"}, text={0: line, 1: line},
        findings=(),
    )  # fmt: skip


@vector(id="text.fap.gaps", title="Gaps in the frame numbers", tier="semantic", tools=FACE_TOOLS,
        rules=["FBA-50", "FBA-54"])  # fmt: skip
def gaps() -> Accept:
    """Frames 0, 4 and 5 at 29.97 Hz: times are numbers of periods of 100/2997 seconds, exactly."""
    text = "2.1 speech 29.97 3\n" + "".join(f"{_mask((3,))}{number} {number}\n" for number in (0, 4, 5))
    return Accept(_fap(text), values={(2, 3): 5}, text={1: '"time":"400/2997"', 2: '"time":"500/2997"'}, findings=())


@vector(id="text.fap.long", title="A .fap text across the 65,536th byte", tier="stress", tools=FACE_TOOLS,
        rules=["FBA-50"])  # fmt: skip
def long() -> Accept:
    """Comments before the header, so many that a mask lies across the end of a buffer of 64 KiB."""
    comment = "# a line of comment, which says nothing at all about the frames\n"
    room = (1 << 16) - len(_HEADER) - 60
    comments = comment * (room // len(comment)) + f"#{'.' * (room % len(comment) - 2)}\n"
    return Accept(_fap(comments + _PLAIN), lines=2, values=_VALUES, findings=())


@vector(id="text.fap.masks", title="Masks that change", tier="semantic", tools=FACE_TOOLS, rules=["FBA-50", "FBA-54"])
def masks() -> Accept:
    """A FAP whose digit is 0 keeps its value, state R; one that never had a value is U; a mask of zeros is legal."""
    text = "2.1 speech 25 3\n" + _mask((3, 4)) + "0 1 2\n" + _mask((68,)) + "1 -7\n" + _mask(()) + "2\n"
    states = {(1, 3): "R", (1, 68): "T", (2, 68): "R", (2, 67): "U"}
    return Accept(_fap(text), values={(2, 3): 1, (2, 4): 2, (2, 68): -7, (2, 5): None}, states=states, findings=())


@vector(id="text.fap.extremes", title="The largest values of .fap text", tier="stress", tools=FACE_TOOLS,
        rules=["FBA-50"], value_classes=["max", "min"])  # fmt: skip
def extremes() -> Accept:
    """32-bit integers, with leading zeros and signs; the largest frame number; a rate with 20 decimal places."""
    text = f"2.1 n 0.00000000000000000001 2\n{_mask((3, 4))}0 2147483647 -2147483648\n"
    text += f"{_mask((3, 4))}2147483647 +0000000000007 -0\n"
    return Accept(_fap(text), values={(0, 3): 2147483647, (0, 4): -2147483648, (1, 3): 7, (1, 4): 0}, findings=())


_FAP_1: Final = _HEADER + _mask((1,)) + "0 5\n" + _mask((1,)) + "1 5 0 63 0\n"


@family(
    {
        "crlf": (_PLAIN.replace("\n", "\r\n"), "text-crlf"),
        "tabs": (_PLAIN.replace("100 ", "100\t"), "text-tabs"),
        "trailing blanks": (
            _PLAIN.replace("-3400", "-3400 ").replace(_SECOND, "  \n" + _SECOND), "text-trailing-blanks",
        ),
        "blank in name": (_PLAIN.replace("speech", "my speech 2"), "text-blank-in-name"),
        "backslash in name": (_PLAIN.replace("speech", "C:\\speech"), "text-backslash-in-name"),
        "comment between": (_PLAIN.replace(_SECOND, "  # half way\n" + _SECOND), "text-comment-between"),
        "decimal": (_PLAIN.replace(" 100 ", " 99.5 ").replace("-1700", "-1.70049e3"), "text-decimal"),
        "69 columns": (_PLAIN.replace(" 0\n", " 0 0\n"), "text-69-columns"),
        "first frame 1": (_PLAIN.replace("1 140", "2 140").replace("0 100", "1 100"), "text-first-frame-one"),
        "version 2.2": (_PLAIN.replace("2.1", "2.2"), "text-version"),
        "version 2.0": (_PLAIN.replace("2.1", "2.0"), "text-version"),
        "nframes": (_PLAIN.replace("25 2\n", "25 7\n"), "text-nframes"),
        "no final newline": (_PLAIN[:-1], "text-no-final-newline"),
    },
    id="text.fap.dialect.{case}", title=".fap in the wild: {case}", tier="semantic", tools=FACE_TOOLS,
    rules=["FBA-51"], features=["dialect"],
)  # fmt: skip
def dialect(case: tuple[str, str]) -> Accept:
    """A text that is not plain 2.1 ({case}), as files from elsewhere are: it says the same, and a checker says so."""
    text, finding = case
    return Accept(_fap(text), lines=2, values=_VALUES, text={1: '"time":"1/25"'}, findings=(finding,))


@family(
    {
        "no header": (_FIRST + _SECOND, ("text-no-header",), '"time":"1/30"'),
        "single viseme": (_FAP_1, ("text-single-viseme",), '"viseme":{"select1":5,"select2":0,"blend":63,"def":0}'),
        "intensity minus one": (
            _HEADER.replace("2\n", "1\n") + _mask((2,)) + "0 1 -1 2 40 0 0\n", ("text-intensity-minus-one",),
            '"intensity1":-1',
        ),
        "several": (
            _PLAIN.replace("\n", "\r\n").replace("100 ", "100\t")[:-2], ("text-crlf", "text-tabs",
            "text-no-final-newline"), '"time":"1/25"',
        ),
    },
    id="text.fap.dialect.{case}", title=".fap in the wild: {case}", tier="semantic", tools=FACE_TOOLS,
    rules=["FBA-51"], features=["dialect"],
    notes="What these say is this suite's reading (AMB-FBA-11): the rate without a header is 30, -1 is kept.",
)  # fmt: skip
def odd_dialect(case: tuple[str, tuple[str, ...], str]) -> Accept:
    """A text that is not plain 2.1 ({case}); what is missing is filled in, nothing is repaired."""
    text, findings, part = case
    return Accept(_fap(text), text={-1: part}, findings=findings)


@vector(id="text.fap.dialect.halves", title="Decimals are rounded away from zero at halves", tier="semantic",
        tools=FACE_TOOLS, rules=["FBA-51"], features=["dialect"], value_classes=["half"])  # fmt: skip
def halves() -> Accept:
    """0.5, -0.5, 1.5, 2.5, 0.49999999999999999999, 25e-1, .5E1 and -7. : exact, by digits."""
    text = "2.1 n 25 1\n" + _mask(range(3, 11)) + "0 0.5 -0.5 1.5 2.5 0.49999999999999999999 25e-1 .5E1 -7.\n"
    values = dict(zip(((0, fap) for fap in range(3, 11)), (1, -1, 2, 3, 0, 3, 5, -7), strict=True))
    return Accept(_fap(text), values=values, findings=("text-decimal",))


_LIST: Final = InconsistentSemantics
_Broken = tuple[str, type[SnhcError], str, int]


@family(
    {
        "empty": ("", InputFormat, "FBA-50", 1),
        "only comments": ("# a\n# b\n", InputFormat, "FBA-50", 1),
        "binary": ("\0\1\2" + _PLAIN, InputFormat, "FBA-50", 1),
        "version 3": (_PLAIN.replace("2.1", "3.0"), InputFormat, "FBA-50", 1),
        "no version": (_PLAIN.replace("2.1 ", ""), InputFormat, "FBA-50", 1),
        "three fields": ("2.1 25 2\n" + _FIRST, InputFormat, "FBA-50", 1),
        "rate 0": (_PLAIN.replace("25 2", "0.0 2"), ForbiddenValue, "FBA-37", 1),
        "rate negative": (_PLAIN.replace("25 2", "-25 2"), RangeViolation, "FBA-50", 1),
        "rate no number": (_PLAIN.replace("25 2", "fast 2"), InputFormat, "FBA-50", 1),
        "rate too fine": (_PLAIN.replace("25 2", f"25.{'0' * 20}1 2"), InputFormat, "FBA-50", 1),
        "nframes negative": (_PLAIN.replace("25 2", "25 -2"), RangeViolation, "FBA-50", 1),
        "nframes no number": (_PLAIN.replace("25 2", "25 two"), InputFormat, "FBA-50", 1),
        "control character": (_PLAIN.replace("speech", "spe\x07ch"), InputFormat, "FBA-50", 1),
        "67 columns": (_HEADER + _FIRST.replace(" 0\n", "\n"), InputFormat, "FBA-50", 2),
        "70 columns": (_HEADER + _FIRST.replace(" 0\n", " 0 0 0\n"), InputFormat, "FBA-50", 2),
        "69th column 1": (_HEADER + _FIRST.replace(" 0\n", " 0 1\n"), InputFormat, "FBA-50", 2),
        "mask digit 2": (_HEADER + _FIRST.replace(" 0\n", " 2\n"), InputFormat, "FBA-50", 2),
        "mask digit letter": (_HEADER + _FIRST.replace(" 0\n", " x\n"), InputFormat, "FBA-50", 2),
        "mask digits joined": (_HEADER + _FIRST.replace("0 0\n", "00\n"), InputFormat, "FBA-50", 2),
        "values missing": (_HEADER + _FIRST.replace(" -3400", ""), InputFormat, "FBA-50", 3),
        "values too many": (_HEADER + _FIRST.replace("-3400", "-3400 1"), InputFormat, "FBA-50", 3),
        "no values": (_HEADER + _mask((3, 48)), Truncated, "FBA-50", 2),
        "frame number twice": (_PLAIN.replace("1 140", "0 140"), _LIST, "FBA-50", 5),
        "frame number negative": (_HEADER + _FIRST.replace("0 100", "-1 100"), RangeViolation, "FBA-50", 3),
        "frame number too large": (_PLAIN.replace("1 140", "2147483648 140"), RangeViolation, "FBA-50", 5),
        "value too large": (_PLAIN.replace("140", "2147483648"), RangeViolation, "FBA-50", 5),
        "value far too large": (_PLAIN.replace("140", "9" * 400), RangeViolation, "FBA-50", 5),
        "decimal too large": (_PLAIN.replace("140", "2147483647.5"), RangeViolation, "FBA-50", 5),
        "decimal far too large": (_PLAIN.replace("140", "1e99"), RangeViolation, "FBA-50", 5),
        "exponent too large": (_PLAIN.replace("140", "1e1000"), InputFormat, "FBA-50", 5),
        "value no number": (_PLAIN.replace("140", "1-40"), InputFormat, "FBA-50", 5),
        "value a word": (_PLAIN.replace("140", "nan"), InputFormat, "FBA-50", 5),
        "NUL in a line": ("# far behind\n" * 700 + _PLAIN.replace("140", "1\0"), InputFormat, "FBA-50", 705),
        "viseme 15": (_HEADER + _mask((1,)) + "0 15 0 63 0\n", RangeViolation, "FBA-50", 3),
        "viseme negative": (_HEADER + _mask((1,)) + "0 3 -1 63 0\n", RangeViolation, "FBA-50", 3),
        "viseme def 2": (_HEADER + _mask((1,)) + "0 3 1 63 2\n", RangeViolation, "FBA-50", 3),
        "single viseme 15": (_HEADER + _mask((1,)) + "0 15\n", RangeViolation, "FBA-50", 3),
        "expression 7": (_HEADER + _mask((2,)) + "0 1 10 7 10 0 0\n", RangeViolation, "FBA-50", 3),
        "init face 2": (_HEADER + _mask((2,)) + "0 1 10 6 10 2 0\n", RangeViolation, "FBA-50", 3),
    },
    id="text.fap.error.{case}", title=".fap with a fault: {case}", tier="error", tools=FACE_TOOLS, rules=["CNF-25"],
)  # fmt: skip
def broken(case: _Broken) -> Reject:
    """One thing in the text is wrong: {case}. The fault names its line; the frames before it are good."""
    text, error, rule, line = case
    return Reject(_fap(text), error, rule, line=line)


@family(
    {
        "comment": ("# " + "x" * 150 + "\n" + _PLAIN, 1), "line": (_HEADER + _FIRST + "# " + "x" * 200 + "\n", 4),
        "last line": (_HEADER + _FIRST + "x" * 200, 4), "last line by one": (_HEADER + _FIRST + "x" * 141, 4),
        "comment lines": (f"#{'x' * 90}\n" * 2 + _PLAIN, 2),
    },
    id="text.fap.error.limit.{case}", title=".fap with lines past the limit: {case}", tier="error", tools=FACE_TOOLS,
    rules=["CNF-22"], options=DecodeOptions(limits={"text_line_bytes": 140}),
)  # fmt: skip
def limit(case: tuple[str, int]) -> Reject:
    """The limit is lowered to 140 bytes, a mask has 135: {case}."""
    text, line = case
    return Reject(_fap(text), ResourceLimit, "CNF-22", line=line)


@vector(id="text.fap.limit.reached", title=".fap with lines at the limit", tier="stress", tools=FACE_TOOLS,
        rules=["CNF-22"], options=DecodeOptions(limits={"text_line_bytes": 135}))  # fmt: skip
def limit_reached() -> Accept:
    """The limit is lowered to 135 bytes, which a mask line has: its end does not count, also not one of CR LF."""
    return Accept(_fap(_PLAIN.replace("\n", "\r\n")), lines=2, values=_VALUES)


@family(
    {
        "crlf": (_PLAIN.replace("\n", "\r\n"), 1), "tabs": (_PLAIN.replace("100 ", "100\t"), 3),
        "no header": (_FIRST + _SECOND, 1), "decimal": (_PLAIN.replace("140", "140.0"), 5),
        "nframes": (_PLAIN.replace("25 2", "25 3"), 1), "version": (_PLAIN.replace("2.1", "2.2"), 1),
        "intensity": (_HEADER + _mask((2,)) + "0 1 -1 2 40 0 0\n", 3),
    },
    id="text.fap.error.strict.{case}", title=".fap under --strict: {case}", tier="error", tools=FACE_TOOLS,
    rules=["FBA-51"], features=["dialect"], options=DecodeOptions(strict=True),
)  # fmt: skip
def strict(case: tuple[str, int]) -> Reject:
    """Under --strict a text has to be plain 2.1: {case} is refused where it stands."""
    text, line = case
    return Reject(_fap(text), InputFormat, "FBA-50", line=line)


# -- bodies ------------------------------------------------------------------------------------------------------------


def _bap(width: int, *frames: tuple[Sequence[int], str], header: str = "2.1 walk 25 {}\n") -> Document:
    text = header.format(len(frames)) + "".join(f"{_mask(numbers, width)}{values}\n" for numbers, values in frames)
    return Document(BAP, text.encode())


@family(
    {"186 columns": (186, ()), "296 columns": (296, ()), "295 columns": (295, ("text-295-columns",))},
    id="text.bap.{case}", title=".bap text with {case}", tier="syntax", tools=BODY_TOOLS, rules=["FBA-53"],
)  # fmt: skip
def body(case: tuple[int, tuple[str, ...]]) -> Accept:
    """Masks of {case}; the values of the masked BAPs ascending, no high-level fields."""
    width, findings = case
    document = _bap(width, ((1, 186), "0 5 -7"), ((186,), "2 9"))
    text = {0: '"baps":{"1":5,"186":-7}', 1: '"time":"2/25"'}
    return Accept(document, lines=2, text=text, findings=findings)


@family(
    {
        "187 columns": (_bap(187, ((1,), "0 5")), InputFormat, 2),
        "values missing": (_bap(296, ((1, 2), "0 5")), InputFormat, 3),
        "frame number twice": (_bap(186, ((1,), "0 5"), ((1,), "0 5")), _LIST, 5),
        "value too large": (_bap(186, ((1,), f"0 {1 << 31}")), RangeViolation, 3),
        "no header field": (_bap(186, ((1,), "0 5"), header="25 {}\n"), InputFormat, 1),
    },
    id="text.bap.error.{case}", title=".bap with a fault: {case}", tier="error", tools=BODY_TOOLS, rules=["CNF-25"],
)  # fmt: skip
def broken_body(case: tuple[Document, type[SnhcError], int]) -> Reject:
    """One thing in the text is wrong: {case}."""
    document, error, line = case
    return Reject(document, error, "FBA-53", line=line)
