"""Mutants of the temporal header and the clock.

Rules: FBA-6, FBA-7, FBA-8, FBA-37, FBA-38, FBA-39.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_HEADER = "syntax.temporal:temporal_header"
_TICK = "syntax.temporal:Clock.tick"
_SKIP = "syntax.temporal:_number_of_frames_to_skip"

mutant(
    "fba.header.rate-1001-in-integers",
    "1000/1001 is computed in integers",
    ["FBA-37"],
    edit(_TICK, "rate = rate * 1000 / 1001", "rate = Fraction(int(rate) * 1000 // 1001)"),
)
mutant(
    "fba.header.rate-1001-inverted",
    "frequency_offset multiplies by 1001/1000",
    ["FBA-37"],
    edit(_TICK, "rate * 1000 / 1001", "rate * 1001 / 1000"),
)
mutant(
    "fba.header.rate-1001-ignored",
    "frequency_offset is read and not used",
    ["FBA-37"],
    edit(_TICK, "if h.frequency_offset:", "if h.frequency_offset > 1:"),
)
mutant(
    "fba.header.rate-1001-as-float",
    "1000/1001 is a rounded decimal, 0.999",
    ["FBA-37"],
    edit(_TICK, "rate * 1000 / 1001", "rate * 999 / 1000"),
)
mutant(
    "fba.header.sixteenths-ignored",
    "`seconds` of the frame rate is read and not used",
    ["FBA-37"],
    edit(_TICK, "h.frame_rate * 16 + h.seconds", "h.frame_rate * 16"),
)
mutant(
    "fba.header.sixteenths-as-tenths",
    "`seconds` of the frame rate is taken for fifteenths",
    ["FBA-37"],
    edit(_TICK, "Fraction(h.frame_rate * 16 + h.seconds, 16)", "Fraction(h.frame_rate * 15 + h.seconds, 15)"),
)
mutant(
    "fba.header.rate-default-25",
    "Before any rate is sent it is 25",
    ["FBA-37"],
    edit("syntax.temporal:Clock.__init__", "self.rate = Fraction(30)", "self.rate = Fraction(25)"),
    edit("syntax.temporal:Clock.__init__", "self._den = 30", "self._den = 25"),
)
mutant(
    "fba.header.rate-zero-accepted",
    "A frame rate of 0 is accepted and ignored",
    ["FBA-37"],
    edit(_HEADER, "io.require(h.frame_rate != 0 or h.seconds != 0, _RATE_ZERO, 0, start, io.tell())", "pass"),
)
mutant(
    "fba.header.rate-below-one-refused",
    "frame_rate 0 is refused although `seconds` is not 0",
    ["FBA-37"],
    edit(_HEADER, "h.frame_rate != 0 or h.seconds != 0", "h.frame_rate != 0"),
)
mutant(
    "fba.header.rate-of-the-old-period",
    "A new rate is applied to all the time that has passed",
    ["FBA-38", "FBA-37"],
    edit(
        _TICK, "self._base += Fraction(self._periods * self._num, self._den)\n                self._periods = 0", "pass"
    ),
)
mutant(
    "fba.header.rate-not-kept",
    "The rate goes back to 30 in a plane that does not carry it",
    ["FBA-37", "FBA-38"],
    edit(
        _TICK,
        "if h.is_time_code:",
        "if not h.is_frame_rate:\n            self._num, self._den = 1, 30\n        if h.is_time_code:",
    ),
)
mutant(
    "fba.header.time-code-repeated",
    "A time code is repeated for every later plane: time does not run on",
    ["FBA-38"],
    edit(_TICK, "self._periods += 1 if skipped_before", "self._periods += 0 if self._base else 1 if skipped_before"),
)
mutant(
    "fba.header.time-code-not-used",
    "A time code is read, and time runs on as if there were none",
    ["FBA-38", "FBA-7"],
    edit(_TICK, "self._base = Fraction(time_code)\n            self._periods = 0", "pass"),
)
mutant(
    "fba.header.time-code-added",
    "A time code is added to the running time",
    ["FBA-38", "FBA-7"],
    edit(_TICK, "self._base = Fraction(time_code)", "self._base += Fraction(time_code)"),
)
mutant(
    "fba.header.time-code-keeps-periods",
    "A time code replaces the start of the clock and not the frames counted since",
    ["FBA-38"],
    edit(_TICK, "self._base = Fraction(time_code)\n            self._periods = 0", "self._base = Fraction(time_code)"),
)
mutant(
    "fba.header.time-code-hours-in-minutes",
    "Hours of the time code count 60 seconds",
    ["FBA-7", "FBA-38"],
    edit(_TICK, "h.time_code_hours * 3600", "h.time_code_hours * 60"),
)
mutant(
    "fba.header.time-code-hours-24",
    "Hour 24 is accepted",
    ["FBA-7"],
    value("syntax.temporal:TIME_CODE_HOURS.hi", 23, 24),
)
mutant(
    "fba.header.time-code-minutes-not-checked",
    "Minutes past 59 are accepted",
    ["FBA-7"],
    value("syntax.temporal:TIME_CODE_MINUTES.hi", 59, 63),
)
mutant(
    "fba.header.time-code-seconds-60",
    "Second 60 is accepted, as a leap second",
    ["FBA-7"],
    value("syntax.temporal:TIME_CODE_SECONDS.hi", 59, 60),
)
mutant(
    "fba.header.time-code-hours-below-23",
    "Hour 23 is refused",
    ["FBA-7"],
    value("syntax.temporal:TIME_CODE_HOURS.hi", 23, 22),
)
mutant(
    "fba.header.time-code-marker-before-minutes",
    "The marker of the time code is read before the minutes",
    ["FBA-7"],
    edit(
        _HEADER,
        "h.time_code_minutes = io.u(TIME_CODE_MINUTES, 6, h.time_code_minutes)\n"
        "            io.marker(TIME_CODE_MARKER)",
        "io.marker(TIME_CODE_MARKER)\n"
        "            h.time_code_minutes = io.u(TIME_CODE_MINUTES, 6, h.time_code_minutes)",
    ),
)
mutant(
    "fba.header.time-code-marker-not-checked",
    "The marker of the time code is passed over unread",
    ["FBA-7", "CNF-7"],
    edit(_HEADER, "io.marker(TIME_CODE_MARKER)", "io.u(SKIP_FRAMES, 1, 1)"),
)
mutant(
    "fba.header.in-inter-planes",
    "is_frame_rate and is_time_code are read in inter planes too",
    ["FBA-6", "FBA-7"],
    edit(_HEADER, "if is_intra:", "if True:"),
)
mutant(
    "fba.header.time-code-before-rate",
    "is_time_code is read before is_frame_rate",
    ["FBA-6", "FBA-7"],
    edit(
        _HEADER,
        "h.is_frame_rate = io.u(IS_FRAME_RATE, 1, h.is_frame_rate)\n        if h.is_frame_rate:",
        "h.is_time_code = io.u(IS_TIME_CODE, 1, 0)\n        h.is_frame_rate = io.u(IS_FRAME_RATE, 1, 0)\n"
        "        if h.is_frame_rate:",
    ),
    edit(_HEADER, "h.is_time_code = io.u(IS_TIME_CODE, 1, h.is_time_code)", "pass"),
)
mutant(
    "fba.header.skip-once",
    "number_of_frames_to_skip is read once: 15 does not announce another group",
    ["FBA-8"],
    edit(_SKIP, "while group == 15:", "while total == 0 and group == 15:"),
)
mutant(
    "fba.header.skip-times-15",
    "Groups of number_of_frames_to_skip are read as digits to the base 15",
    ["FBA-8"],
    edit(_SKIP, "total += group", "total = total * 15 + group"),
)
mutant(
    "fba.header.skip-last-group-only",
    "Only the last group of number_of_frames_to_skip counts",
    ["FBA-8"],
    edit(_SKIP, "total += group", "total = group"),
)
mutant(
    "fba.header.skip-before-the-plane",
    "Skipped frames lie before the plane",
    ["FBA-38", "FBA-8"],
    edit(
        _TICK,
        "else:\n            self.went_back = False",
        "else:\n            skipped_before = True\n            self.went_back = False",
    ),
)
mutant(
    "fba.header.skip-off-by-one",
    "A plane with skipped frames takes no period of its own",
    ["FBA-38", "FBA-8"],
    edit(_TICK, "h.number_of_frames_to_skip + 1", "(h.number_of_frames_to_skip or 1)"),
)
mutant(
    "fba.header.skip-ignored",
    "Skipped frames are read and take no time",
    ["FBA-38", "FBA-8"],
    edit(_TICK, "h.number_of_frames_to_skip + 1", "1"),
)
mutant(
    "fba.header.skip-limit-off-by-one",
    "The limit of skipped frames is one too low",
    ["FBA-8", "CNF-22"],
    edit(_SKIP, "if total > io.limits.skipped_frames", "if total >= io.limits.skipped_frames"),
)
mutant(
    "fba.header.skip-not-limited",
    "Skipped frames are not limited",
    ["FBA-8", "CNF-22"],
    edit(_SKIP, "if total > io.limits.skipped_frames", "if False"),
)
mutant(
    "fba.header.time-code-back-not-reported",
    "A time code that goes back is not reported",
    ["FBA-38", "CNF-23"],
    edit(_TICK, "time_code * self._last[1] < self._last[0]", "False"),
    findings=True,
)
mutant(
    "fba.header.time-code-equal-reported",
    "A time code equal to the time before is reported as going back",
    ["FBA-38", "CNF-23"],
    edit(_TICK, "time_code * self._last[1] < self._last[0]", "time_code * self._last[1] <= self._last[0]"),
    findings=True,
)
mutant(
    "fba.header.per-kind-of-data",
    "The temporal header is read once for FAP data and once more for BAP data",
    ["FBA-39"],
    edit(
        "face.syntax:fba_object_plane",
        'if mask or io.readings.empty_plane_header == "header":\n'
        "        temporal_header(io, plane.header, plane.is_intra)",
        "for _ in range(2 if mask == 3 else 1):\n        temporal_header(io, plane.header, plane.is_intra)",
    ),
)
mutant(
    "fba.header.not-with-bodies-alone",
    "A plane with BAP data alone is taken to have no temporal header",
    ["FBA-39"],
    edit(
        "face.syntax:fba_object_plane",
        'if mask or io.readings.empty_plane_header == "header":',
        "if mask != 2:",
    ),
)
