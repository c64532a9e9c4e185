"""FAP segments coded with the DCT. All of these streams use the entropy tables of profile P1, which are provisional."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from snhc.reference_impl.bitstream.errors import RangeViolation
from snhc.reference_impl.face.dct_syntax import CoefficientRun
from snhc.reference_impl.systems.encoding import encode_fap
from snhc.reference_impl.systems.stream import trace_stream, write_stream

from ..builders import all_lists, body, empty, inter, intra, stream, with_code
from ..dct_builders import Expression, Viseme, coefficients, dct_inter, dct_intra, listed
from ..recipe import Accept, Ambiguous, family, vector
from ..sequences import expressions, speech

TOOLS: Final = ("fba", "dct-p1")
PROVISIONAL: Final = ("provisional-tables",)
NOTES: Final = "Entropy profile P1: provisional entropy tables."


def _inter(dc: int, ac: Mapping[int, int] | None = None, dc_escape: int | None = None) -> CoefficientRun:
    return coefficients(dc, ac, is_intra=False, dc_escape=dc_escape)


@vector(
    id="fap.dct.example.1",
    title="Worked DCT stream: two FAPs, intra and inter segment",
    tier="semantic",
    rules=["DCT-1", "DCT-2", "DCT-3", "DCT-4", "DCT-5", "DCT-6", "DCT-7", "DCT-13", "FBA-12"],
    features=["inter", "run"],
    tools=TOOLS,
    notes=NOTES,
)
def example_1() -> Accept:
    """FAP 3 and FAP 49 at fap_quant 8. The coefficient at index 15 of FAP 49 is followed by no end symbol.

    A decoder that reads one there loses its place.
    """
    first = dct_intra({3: listed([6, -5, 0, 2]), 49: coefficients(-3, {15: 1})})
    return Accept(
        stream(first, dct_inter(first, {3: _inter(-2, {1: 1}), 49: _inter(0)})),
        same_as=bytes.fromhex("000001baa112c00049255244001a970bfff4018a9cb93f000001b1"),
        lines=32,
        values={(0, 3): -52, (11, 3): 202, (0, 49): -659, (7, 49): -1842, (16, 3): 62, (31, 3): -2, (31, 49): -765},
        times={15: "1/2", 16: "8/15", 31: "31/30"},
        findings=PROVISIONAL,
    )


@family(
    {"0": 0, "32767": 32767, "minus 32767": -32767},
    id="fap.dct.dc.intra.{case}",
    title="Intra DC {case} in 16 bits",
    tier="syntax",
    rules=["DCT-2", "DCT-6"],
    value_classes=["max", "min", "zero"],
    tools=TOOLS,
    notes=NOTES,
)
def intra_dc(value: int) -> Accept:
    """Intra DC {case}, sent as s(16). The FAP behind it shows that the place is kept."""
    return Accept(
        stream(dct_intra({3: coefficients(value), 4: listed([4])})), lines=16, values={(0, 4): 30}, findings=PROVISIONAL
    )


@family(
    {"32768": 32768, "minus 32768": -32768, "largest": 2**30 - 1, "smallest": -(2**30)},
    id="fap.dct.dc.intra-wide.{case}",
    title="Intra DC escaped to 31 bits: {case}",
    tier="syntax",
    rules=["DCT-2", "DCT-6"],
    features=["escape"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)
def intra_dc_wide(value: int) -> Accept:
    """-32768 in 16 bits, then the value in 31 bits: {case}. -32768 itself has to be escaped too."""
    plane = dct_intra({3: coefficients(value), 4: listed([4])}, quant=0)
    rounded = (abs(value) * 5 + 4) // 8 * (1 if value > 0 else -1)
    return Accept(stream(plane), lines=16, values={(0, 3): rounded, (0, 4): 3}, findings=PROVISIONAL)


@family(
    {
        "255": 255, "minus 255": -255, "256": 256, "minus 256": -256, "32767": 32767, "minus 32767": -32767,
        "32768": 32768, "minus 32768": -32768, "largest": 2**31 - 1, "smallest": -(2**31),
    },
    id="fap.dct.dc.inter.{case}",
    title="Inter DC difference {case}",
    tier="syntax",
    rules=["DCT-3", "DCT-6"],
    features=["escape", "inter"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)  # fmt: skip
def inter_dc(difference: int) -> Accept:
    """The difference {case}: a word up to 255, then 16 bits, then -32768 and 32 bits (31 in intra segments).

    The second inter segment takes it back.
    """
    first = dct_intra({3: listed([8]), 4: listed([0])})
    back = -difference if difference > -(2**31) else 2**31 - 1
    planes = [first, dct_inter(first, {3: _inter(difference)}), dct_inter(first, {3: _inter(back), 4: _inter(4)})]
    return Accept(
        stream(*planes),
        lines=48,
        values={(32, 3): 60 if back == -difference else 53, (32, 4): 30},
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.dc.prediction",
    title="The predictor of DC is the quantised DC of the last segment",
    tier="semantic",
    rules=["DCT-3", "DCT-8", "DCT-13"],
    features=["inter"],
    tools=TOOLS,
    notes=NOTES,
)
def prediction() -> Accept:
    """Differences add up in the quantised domain, whatever was rounded; an intra segment starts anew.

    fap_quant 0, DC step 2.5: the values are DC * 0.625, rounded. A decoder that predicts from values drifts.
    """
    first = dct_intra({3: listed([1])}, quant=0)
    planes = [first, *(dct_inter(first, {3: _inter(1)}) for _ in range(7)), dct_intra({3: listed([-1])}, quant=0)]
    values = {(16 * i, 3): value for i, value in enumerate((1, 1, 2, 3, 3, 4, 4, 5, -1))}
    return Accept(stream(*planes), lines=144, values=values, findings=PROVISIONAL)


@vector(
    id="fap.dct.idct.halves",
    title="Halves are rounded away from zero",
    tier="semantic",
    rules=["DCT-7"],
    value_classes=["half"],
    tools=TOOLS,
    notes=NOTES,
)
def halves() -> Accept:
    """DC values of 2.5, -2.5, 7.5 and -7.5 exactly: 3, -3, 8, -8. Banker's rounding and truncation show here."""
    plane = dct_intra({3: listed([4]), 4: listed([-4]), 5: listed([12]), 6: listed([-12])}, quant=0)
    return Accept(stream(plane), values={(0, 3): 3, (0, 4): -3, (0, 5): 8, (15, 6): -8}, findings=PROVISIONAL)


@family(
    {
        "255": 255, "minus 256": -256, "256": 256, "minus 257": -257, "32767": 32767, "minus 32767": -32767,
        "32768": 32768, "minus 32768": -32768, "largest": 2**30 - 1, "smallest": -(2**30),
    },
    id="fap.dct.ac.{case}",
    title="AC coefficient {case}",
    tier="syntax",
    rules=["DCT-4", "DCT-6"],
    features=["escape"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)  # fmt: skip
def ac(value: int) -> Accept:
    """{case} at index 8: a word from -256 to 255, then 16 bits, then -32768 and 31 bits."""
    plane = dct_intra({3: coefficients(0, {8: value, 9: -1}), 4: listed([4])}, quant=0)
    return Accept(stream(plane), values={(0, 4): 3}, findings=PROVISIONAL)


@family(
    {
        "ac zero": 0,
        "ac in 16 bits": 1,
        "ac in 31 bits": 2,
        "intra dc": 3,
        "inter dc in 16 bits": 4,
        "inter dc in 32 bits": 5,
    },
    id="fap.dct.non-canonical.{case}",
    title="An escape that is not needed: {case}",
    tier="syntax",
    rules=["DCT-3", "DCT-4"],
    features=["escape"],
    tools=TOOLS,
    notes=NOTES,
)
def non_canonical(case: int) -> Accept:
    """A value that the table or the narrow field holds is escaped ({case}); readers take it."""
    first = dct_intra({3: coefficients(5, {2: 7}), 4: listed([4])})
    run = [
        coefficients(5, {2: 0, 4: 1}, escapes={2: 1}), coefficients(5, {2: 7}, escapes={2: 1}),
        coefficients(5, {2: 7}, escapes={2: 2}), coefficients(5, dc_escape=1), _inter(3, dc_escape=1),
        _inter(3, dc_escape=2),
    ][case]  # fmt: skip
    odd = dct_intra({3: run, 4: listed([4])}) if case < 4 else dct_inter(first, {3: run})
    return Accept(stream(first, odd), lines=32, values={(16, 4): 30}, findings=(*PROVISIONAL, "non-canonical"))


@vector(
    id="fap.dct.run.all",
    title="Runs of 0 to 14 zeros",
    tier="syntax",
    rules=["DCT-4"],
    features=["run"],
    value_classes=["max", "zero"],
    tools=TOOLS,
    notes=NOTES,
)
def runs() -> Accept:
    """FAP n + 3 has one coefficient behind n zeros; the one at index 15 has no end symbol behind it."""
    faps = {run + 3: coefficients(4, {run + 1: 3}) for run in range(15)}
    return Accept(stream(dct_intra({**faps, 19: listed([3])})), values={(0, 19): 30}, findings=PROVISIONAL)


@vector(
    id="fap.dct.run.to-index-15",
    title="Segments that end at index 15",
    tier="syntax",
    rules=["DCT-4"],
    features=["run"],
    tools=TOOLS,
    notes=NOTES,
)
def full() -> Accept:
    """Coefficients at every index, at odd ones, and at 14 and 15: all without an end symbol."""
    faps = {
        3: coefficients(1, {k: k - 8 for k in range(1, 16) if k != 8} | {8: 1}),
        4: coefficients(1, dict.fromkeys(range(1, 16, 2), -1)),
        5: coefficients(1, {14: 2, 15: -2}),
        6: listed([4]),
    }
    return Accept(stream(dct_intra(faps)), values={(0, 6): 30}, findings=PROVISIONAL)


def _steps(largest: int) -> list[int]:
    """Values of 0..largest whose differences are every one from -largest to largest."""
    return [0, *(value for d in range(largest + 1) for value in (d, 0))]


@vector(
    id="fap.dct.words.every",
    title="Every word of every table",
    tier="stress",
    rules=["DCT-1", "DCT-3", "DCT-4", "DCT-9", "DCT-10", "DCT-12"],
    features=["escape", "expression", "run", "viseme"],
    value_classes=["max", "min", "zero"],
    tools=TOOLS,
    notes=NOTES,
)
def every_word() -> Accept:
    """All 68 FAPs over nine segments: each symbol of the six tables of P1 is sent at least once."""
    levels = iter([v for v in range(-256, 256) if v] + [256])
    faps = {fap: coefficients(0, {fap - 2: 1}) for fap in range(3, 18)}
    faps |= {fap: coefficients(0, {k: next(levels, 1) for k in range(1, 16)}) for fap in range(18, 69)}
    selects, emotions, amounts = (_steps(n) + [0] * 145 for n in (14, 6, 63))
    visemes: list[Viseme] = [(selects[t], selects[t + 1], amounts[t], t & 1) for t in range(144)]
    shown: list[Expression] = [
        (emotions[t], emotions[t + 1], amounts[t], amounts[t + 1], t & 1, t >> 1 & 1) for t in range(144)
    ]
    first = dct_intra(faps, viseme=visemes[:16], expression=shown[:16])
    planes = [first]
    differences = iter([*range(-255, 256), 256])
    for at in range(16, 144, 16):
        runs = {fap: _inter(next(differences, 0)) for fap in range(3, 69)}
        planes.append(dct_inter(first, runs, viseme=visemes[at : at + 16], expression=shown[at : at + 16]))
    return Accept(stream(*planes), lines=144, findings=PROVISIONAL)


@family(
    {"0": 0, "1": 1, "2": 2, "15": 15, "31": 31},
    id="fap.dct.quant.{case}",
    title="fap_quant {case}",
    tier="semantic",
    rules=["DCT-5", "FBA-9"],
    features=["fap-quant"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)
def quant(index: int) -> Accept:
    """Step sizes at index {case} of the scale list, for FAPs of small and large base steps. 0 is not lossless here."""
    scale = {0: 1, 1: 1, 2: 2, 15: 42, 31: 1039}[index]
    # DC 48 is 48 / 12 = 4 base steps times the scale.
    faps = {3: listed([48]), 18: listed([48]), 23: listed([48]), 48: listed([48]), 63: listed([48, 1])}
    return Accept(
        stream(dct_intra(faps, quant=index)),
        values={(0, 3): 30 * scale, (0, 18): 20 * scale, (0, 23): 1700 * scale, (0, 48): 680 * scale},
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.viseme",
    title="Viseme segments",
    tier="semantic",
    rules=["DCT-9", "DCT-11", "DCT-12"],
    features=["viseme", "inter"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)
def viseme() -> Accept:
    """Instant 0 of an intra segment is sent as it is, all others as differences from the instant before.

    The first instant of the inter segment differs from the last one of the segment before. The values are not scaled.
    """
    first = dct_intra(viseme=[(14, 0, 63, 1), (0, 14, 0, 0), (3, 4, 31, 1), (14, 14, 63, 0)], quant=31)
    second = dct_inter(first, viseme=[(0, 1, 62, 1), (0, 1, 1, 0)])
    return Accept(
        stream(first, second),
        lines=32,
        text={
            0: '"viseme":{"select1":14,"select2":0,"blend":63,"def":1}',
            1: '"viseme":{"select1":0,"select2":14,"blend":0,"def":0}',
            15: '"viseme":{"select1":14,"select2":14,"blend":63,"def":0}',
            16: '"viseme":{"select1":0,"select2":1,"blend":62,"def":1}',
            31: '"viseme":{"select1":0,"select2":1,"blend":1,"def":0}',
        },
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.expression",
    title="Expression segments",
    tier="semantic",
    rules=["DCT-10", "DCT-11", "DCT-12"],
    features=["expression", "inter"],
    value_classes=["max", "min"],
    tools=TOOLS,
    notes=NOTES,
)
def expression() -> Accept:
    """Both selects, both intensities, init_face, expression_def; the differences in the same order."""
    first = dct_intra(expression=[(6, 0, 0, 63, 1, 0), (0, 6, 63, 0, 0, 1), (2, 3, 10, 20, 1, 1)])
    second = dct_inter(first, expression=[(3, 2, 20, 10, 0, 0)])
    keys = '"expression":{"select1":%d,"intensity1":%d,"select2":%d,"intensity2":%d,"init_face":%d,"def":%d}'
    return Accept(
        stream(first, second),
        lines=32,
        text={
            0: keys % (6, 0, 0, 63, 1, 0),
            1: keys % (0, 63, 6, 0, 0, 1),
            15: keys % (2, 10, 3, 20, 1, 1),
            16: keys % (3, 20, 2, 10, 0, 0),
        },
        findings=PROVISIONAL,
    )


def _emulating(code: int) -> Iterator[bytes]:
    # A 1, 15 zeros and 31 bits that begin with more zeros: one of the shifts puts a start code at whole bytes.
    for shift in range(7, 15):
        plane = dct_intra({3: coefficients((0x100 | code) << shift), 4: listed([4])}, quant=0)
        data = write_stream(stream(plane, dct_inter(plane, {4: _inter(4)})))
        if bytes((0, 0, 1, code)) in data[5:-5]:
            yield data


@family(
    {"b0": 0xB0, "b1": 0xB1, "ba": 0xBA, "bb": 0xBB},
    id="fap.dct.start-code.{case}",
    title="The payload holds the start code 000001{case}",
    tier="semantic",
    rules=["DCT-15", "DCT-2"],
    features=["escape", "start-code-emulation"],
    tools=TOOLS,
    notes=NOTES,
)
def start_code(code: int) -> Accept:
    """The wide DC of FAP 3 makes the bytes 00 00 01 {case} inside the plane.

    There is no guard in this mode: decoders that look for start codes before they parse cut the plane here.
    """
    (data,) = _emulating(code)
    return Accept(data, lines=32, values={(0, 4): 3, (31, 4): 5}, findings=PROVISIONAL)


@vector(
    id="fap.dct.switch",
    title="Arithmetic and DCT planes alternate",
    tier="semantic",
    rules=["DCT-13", "FBA-12", "FBA-19", "FBA-34"],
    features=["inter", "ranges"],
    tools=TOOLS,
    notes=NOTES,
)
def switch() -> Accept:
    """Each intra plane says the coding type for the planes behind it.

    Limits sent before a DCT plane still hold behind it; values of FAPs that the DCT planes do not code are retained.
    """
    arithmetic, again = intra({3: 10, 4: 5}, ranges=all_lists(1)), intra({3: -7, 4: 1})
    dct = dct_intra({3: listed([4]), 5: listed([8])})
    planes = [
        arithmetic, inter(arithmetic, {3: 1}), dct, dct_inter(dct, {3: _inter(4)}), again, inter(again, {3: 2}),
        dct_intra({3: listed([-4])}),
    ]  # fmt: skip
    return Accept(
        stream(*planes),
        lines=52,
        values={(1, 3): 44, (2, 3): 30, (2, 4): 10, (18, 3): 60, (34, 3): -28, (35, 3): -20, (36, 3): -30},
        states={(2, 4): "R", (34, 5): "R", (36, 4): "R"},
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.states",
    title="Mask types and states in DCT segments",
    tier="semantic",
    rules=["DCT-14", "FBA-14", "FBA-34"],
    features=["mask-type-2", "mask-type-3", "states"],
    tools=TOOLS,
    notes=NOTES,
)
def states() -> Accept:
    """All 16 lines of a segment have the states of its plane; a plane without data has R for T."""
    first = dct_intra({3: listed([4]), 19: listed([1]), 31: listed([0])}, types={3: 2, 4: 3})
    letters = "UUT" + "U" * 15 + "T" + "I" * 11 + "T" * 8 + "U" * 30
    after = "UURT" + "U" * 14 + "R" + "U" * 11 + "R" * 8 + "U" * 30
    return Accept(
        stream(first, dct_intra({4: listed([2])}), empty()),
        lines=33,
        text={
            0: f'"state":"{letters}"', 15: f'"state":"{letters}"', 16: f'"state":"{after}"',
            32: '"state":"' + after.replace("T", "R"),
        },
        findings=PROVISIONAL,
    )  # fmt: skip


@vector(
    id="fap.dct.times",
    title="Times of segments, skipped frames, planes without data",
    tier="semantic",
    rules=["DCT-13", "FBA-6", "FBA-7", "FBA-8", "FBA-38"],
    features=["skip", "time-code"],
    tools=TOOLS,
    notes=NOTES,
)
def times() -> Accept:
    """A segment lasts 16 frame periods; skipped frames lie behind it. A plane without data lasts one."""
    first = dct_intra({3: listed([0])}, rate=(25, 0, 0), time=(0, 1, 0), skip=3)
    planes = [first, dct_inter(first, skip=0), empty(skip=1), with_code(dct_inter(first))]
    return Accept(
        stream(*planes),
        lines=49,
        times={0: "60/1", 15: "303/5", 16: "1519/25", 31: "1534/25", 32: "307/5", 33: "1537/25", 48: "1552/25"},
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.baps",
    title="Body parameters beside a DCT segment",
    tier="semantic",
    rules=["DCT-13", "FBA-40"],
    features=["bap"],
    tools=("fba", "bap", "dct-p1"),
    notes=NOTES,
)
def baps() -> Accept:
    """A plane with a DCT segment and arithmetic-coded BAPs: they belong to its first instant."""
    first = body({2: 7, 5: -3}, face=dct_intra({3: listed([4])}), ranges=all_lists(1))
    return Accept(
        stream(first, dct_inter(first, {3: _inter(4)}, baps={2: 1})),
        lines=32,
        values={(31, 3): 60},
        findings=PROVISIONAL,
    )


@vector(
    id="fap.dct.all-faps",
    title="All 68 FAPs in DCT segments",
    tier="stress",
    rules=["DCT-1", "DCT-5"],
    features=["mask-type-3", "viseme", "expression", "inter"],
    tools=TOOLS,
    notes=NOTES,
)
def all_faps() -> Accept:
    """Every group has mask type 3; viseme, expression, then FAP 3 to 68 ascending, twenty segments long."""
    types = dict.fromkeys(range(1, 11), 3)
    shown: list[Expression] = [(1, 2, t, 63 - t, 0, 0) for t in range(16)]
    spoken: list[Viseme] = [(t % 15, 14 - t % 15, 4 * t, 0) for t in range(16)]
    faps = {
        fap: coefficients(fap - 36, {1 + fap % 15: 2, 15: -1} if fap % 15 != 14 else {15: 3}) for fap in range(3, 69)
    }
    first = dct_intra(faps, types=types, viseme=spoken, expression=shown)
    later = {fap: _inter(fap % 7 - 3, {1 + fap % 14: -2}) for fap in range(3, 69)}
    planes = [first, *(dct_inter(first, later, viseme=spoken, expression=shown) for _ in range(19))]
    return Accept(stream(*planes), lines=320, findings=PROVISIONAL)


@family(
    {"speech": 1, "expressions": 2},
    id="fap.dct.real.{case}",
    title="A sequence of {case}",
    tier="real",
    rules=["DCT-1", "DCT-3", "DCT-4", "DCT-5", "DCT-7", "DCT-13"],
    features=["inter", "run"],
    tools=TOOLS,
    notes=NOTES,
    seed=11,
)
def real(case: int) -> Accept:
    """{case}, made from a seed and coded by our own encoder: 20 segments, intra every 8."""
    file = speech(320, 11) if case == 1 else expressions(320, 11)
    return Accept(encode_fap(file, quant=3, mode="dct"), lines=320, findings=PROVISIONAL)


# -- readings ----------------------------------------------------------------------------------------------------------


@vector(
    id="fap.dct.ambiguous.dc-step",
    title="Ratio of the AC step to the DC step",
    tier="semantic",
    rules=["DCT-5"],
    tools=TOOLS,
    notes=NOTES,
)
def dc_step() -> Ambiguous:
    """DC 24 at fap_quant 8 is 180, or 135 where the ratio is 4 as the paper prints it."""
    first = dct_intra({3: listed([24, 2]), 4: listed([0, 3])})
    return Ambiguous(stream(first, dct_inter(first, {3: _inter(-48)})), "AMB-DCT-1")


@vector(
    id="fap.dct.ambiguous.normalisation",
    title="Scaling of the transform",
    tier="semantic",
    rules=["DCT-7"],
    tools=TOOLS,
    notes=NOTES,
)
def normalisation() -> Ambiguous:
    """DC 32 at fap_quant 8 is 240 with orthonormal factors, 60 with the inverse of an unscaled transform."""
    return Ambiguous(stream(dct_intra({3: listed([32]), 4: listed([8, -3, 0, 5])})), "AMB-DCT-2")


@vector(
    id="fap.dct.ambiguous.intensity",
    title="Blend and intensities, scaled or not",
    tier="semantic",
    rules=["DCT-11"],
    features=["viseme", "expression"],
    tools=TOOLS,
    notes=NOTES,
)
def intensity() -> Ambiguous:
    """Blend 5 at fap_quant 2 is 5, or 10 where fap_scale applies to it."""
    first = dct_intra(viseme=[(1, 2, 5, 0)], expression=[(1, 2, 3, 4, 0, 0)], quant=2)
    return Ambiguous(
        stream(first, dct_inter(first, viseme=[(1, 2, 6, 0)], expression=[(1, 2, 4, 4, 0, 0)])), "AMB-DCT-3"
    )


@vector(
    id="fap.dct.ambiguous.end-symbol",
    title="End symbol behind a coefficient at index 15",
    tier="semantic",
    rules=["DCT-4"],
    features=["run"],
    tools=TOOLS,
    notes=NOTES,
)
def end_symbol() -> Ambiguous:
    """FAP 3 ends at index 15; the DC of FAP 4, which is negative, follows at once.

    Where an end symbol is expected, the sign bit is taken for the word of run 0.
    """
    records = stream(dct_intra({3: coefficients(4, {15: 2}), 4: listed([-4])}))
    rows = [row for part in trace_stream(write_stream(records)) for row in part.trace.rows()]
    (start,) = [start for element, start, _, _, path in rows if element.name == "dc" and path.endswith("fap[4]")]
    return Ambiguous(records, "AMB-DCT-4", {"sent": (RangeViolation, "DCT-4", (start, start + 1))})


@vector(
    id="fap.dct.ambiguous.expression-order",
    title="Order of the fields of an expression",
    tier="semantic",
    rules=["DCT-10"],
    features=["expression"],
    tools=TOOLS,
    notes=NOTES,
)
def expression_order() -> Ambiguous:
    """Constant fields, so that every difference is 0 and both orders can be read to the end of the first segment."""
    return Ambiguous(stream(dct_intra(expression=[(1, 2, 3, 4, 0, 1)])), "AMB-DCT-5")
