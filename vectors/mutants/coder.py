"""Mutants of the arithmetic coder.

Rules: FBA-21..27, FBA-30.
"""

from __future__ import annotations

from .mutant import edit, mutant, value

_KERNEL = "entropy.kernel:decode_segment"
_HALVE = "entropy.model:Model.halve"
_UPDATE = "entropy.model:Model.update"
_RANGES = "face.state:ParameterState.set_ranges"

mutant(
    "fba.coder.scale-off-by-one",
    "The scaled code value is computed without the - 1",
    ["FBA-23"],
    edit(
        _KERNEL,
        "c = ((value - low + 1) * total - 1) // length",
        "c = min((value - low + 1) * total // length, total - 1)",
    ),
)
mutant(
    "fba.coder.length-off-by-one",
    "The length of the interval is high - low",
    ["FBA-23"],
    edit(_KERNEL, "length = high - low + 1", "length = high - low"),
)
mutant(
    "fba.coder.high-off-by-one",
    "The new upper end is not lowered by 1",
    ["FBA-23"],
    edit(_KERNEL, "high = low - 1 + length * (c + 1) // total", "high = min(low + length * (c + 1) // total, 0xFFFF)"),
    edit(_KERNEL, "high = low - 1 + length * top // total", "high = min(low + length * top // total, 0xFFFF)"),
)
mutant(
    "fba.coder.symbols-ascending",
    "Cumulative frequencies run the other way: symbol 0 lies at the bottom of the interval",
    ["FBA-22", "FBA-23"],
    edit(_KERNEL, "s = n - 1 - c", "s = c"),
)
mutant(
    "fba.coder.updated-low-for-high",
    "The upper end is computed with the new lower end",
    ["FBA-23"],
    edit(
        _KERNEL,
        "high = low - 1 + length * top // total\n            low += length * below // total",
        "low += length * below // total\n            high = min(low - 1 + length * top // total, 0xFFFF)",
    ),
)
mutant(
    "fba.coder.intra-models-adapt",
    "I models adapt: FAPs of one range share one within a segment",
    ["FBA-24"],
    edit(
        _RANGES,
        "self.i_models = [Model(i_min[number], i_max[number], False) for number in self.selected]",
        "shared: dict[tuple[int, int], Model] = {}\n        self.i_models = [shared.setdefault((i_min[n], i_max[n]), "
        "Model(i_min[n], i_max[n], True)) for n in self.selected]",
    ),
)
mutant(
    "fba.coder.inter-models-do-not-adapt",
    "P models do not adapt",
    ["FBA-24"],
    edit(_RANGES, "Model(p_min[number], p_max[number], True)", "Model(p_min[number], p_max[number], False)"),
)
mutant(
    "fba.coder.one-model-for-all",
    "All FAPs of one range share one P model",
    ["FBA-22", "FBA-30"],
    edit(
        _RANGES,
        "self.p_models = [Model(p_min[number], p_max[number], True) for number in self.selected]",
        "shared = {}\n"
        "        self.p_models = [shared.setdefault((p_min[n], p_max[n]), Model(p_min[n], p_max[n], True)) for n in "
        "self.selected]",
    ),
)
mutant(
    "fba.coder.models-reset-per-plane",
    "P models are reset with every plane",
    ["FBA-30"],
    edit(
        "face.syntax:fap_levels",
        "models = faps.i_models if is_intra else faps.p_models",
        "models = faps.i_models if is_intra else [Model(m.lo, m.lo + m.n - 1, True) for m in faps.p_models]",
    ),
)
mutant(
    "fba.coder.models-kept-over-intra",
    "P models are not reset by an intra plane whose limits are those before",
    ["FBA-30"],
    edit(
        _RANGES,
        "self.p_models = [Model(p_min[number], p_max[number], True) for number in self.selected]",
        "old = {(m.lo, m.n, label): m for m, label in zip(self.p_models, self.labels)}\n"
        "        self.p_models = [old.get((p_min[n], p_max[n] - p_min[n] + 1, self.parameters.labels[n])) or "
        "Model(p_min[n], p_max[n], True) for n in self.selected]",
    ),
)
mutant(
    "fba.coder.update-by-two",
    "The update adds 2 to the frequency",
    ["FBA-24"],
    edit(
        _KERNEL,
        "freq[s] = top - below + 1\n                model.total = total + 1",
        "freq[s] = top - below + 2\n                model.total = total + 2\n                model.above = -1",
    ),
)
mutant(
    "fba.coder.halve-down",
    "Frequencies are halved with rounding down, and never below 1",
    ["FBA-24"],
    edit(_HALVE, "(f + 1) >> 1", "max(f >> 1, 1)"),
)
mutant(
    "fba.coder.no-rescale",
    "Frequencies are never halved",
    ["FBA-24"],
    edit(_KERNEL, "if total == MAX_FREQUENCY:", "if total == -1:"),
    edit(_UPDATE, "if self.total == MAX_FREQUENCY:", "if self.total == -1:"),
)
mutant(
    "fba.coder.rescale-at-16384",
    "Frequencies are halved at 16384, one symbol late",
    ["FBA-24"],
    value("entropy.kernel:MAX_FREQUENCY", 16383, 16384),
    value("entropy.model:MAX_FREQUENCY", 16383, 16384),
)
mutant(
    "fba.coder.rescale-after-update",
    "Frequencies are halved after the update, not before it",
    ["FBA-24"],
    value("entropy.kernel:MAX_FREQUENCY", 16383, 16382),
    edit(
        _UPDATE,
        "if self.total == MAX_FREQUENCY:\n            self.halve()\n            freq = self.freq\n"
        "            assert freq is not None\n        freq[s] += 1\n        self.total += 1",
        "freq[s] += 1\n        self.total += 1\n        if self.total >= MAX_FREQUENCY:\n            self.halve()\n"
        "            return",
    ),
)
mutant(
    "fba.coder.guard-after-23",
    "The start-code guard is expected behind 23 zero bits",
    ["FBA-25"],
    value("entropy.kernel:GUARD_AFTER", 22, 23),
)
mutant(
    "fba.coder.guard-after-21",
    "The start-code guard is expected behind 21 zero bits",
    ["FBA-25"],
    value("entropy.kernel:GUARD_AFTER", 22, 21),
)
mutant(
    "fba.coder.guard-not-removed",
    "The start-code guard is not removed",
    ["FBA-25"],
    value("entropy.kernel:GUARD_AFTER", 22, 1 << 20),
)
mutant(
    "fba.coder.guard-value-not-checked",
    "A guard of value 0 is accepted",
    ["FBA-25", "FBA-27"],
    edit("entropy.kernel:first_bad_guard", "if not values[i]:", "if False:"),
)
mutant(
    "fba.coder.guard-in-look-ahead-checked",
    "A guard of value 0 behind the end of the segment is an error",
    ["FBA-27", "FBA-26"],
    edit("entropy.kernel:first_bad_guard", "if position >= end:", "if position >= end + 64:"),
)
mutant(
    "fba.coder.guard-at-the-first-preloaded",
    "The 16 preloaded bits do not count toward the zeros before a guard",
    ["FBA-25"],
    edit(_KERNEL, "zeros: i64 = lowest.bit_length() - 1 if lowest else 16", "zeros = 0"),
)
mutant(
    "fba.coder.guard-place",
    "A bad guard is reported at the whole segment's start",
    ["FBA-27", "CNF-21"],
    edit("syntax.reader:Reader.segment", "raise self._bad_guard(bad_guard)", "raise self._bad_guard(start)"),
)
mutant(
    "fba.coder.guard-zeros-over-segments",
    "A segment that ends on 22 zeros is taken to carry a guard behind them",
    ["FBA-25", "FBA-26"],
    edit("entropy.kernel:segment_end", "if before < used:", "if before <= used:"),
)
mutant(
    "fba.coder.rewind-14-raw-bits",
    "At the end of a segment the decoder goes back by 14 raw bits, guards or not",
    ["FBA-26"],
    edit("entropy.kernel:segment_end", "if before < used:", "if before < data_bits:"),
)
mutant(
    "fba.coder.rewind-13-bits",
    "At the end of a segment one look-ahead bit is not given back",
    ["FBA-26"],
    value("entropy.kernel:LOOK_AHEAD", 14, 13),
)
mutant(
    "fba.coder.rewind-16-bits",
    "All 16 look-ahead bits are given back: the two end bits are read again",
    ["FBA-26"],
    value("entropy.kernel:LOOK_AHEAD", 14, 16),
)
mutant(
    "fba.coder.no-empty-segment",
    "Without selected FAPs no segment is read",
    ["FBA-26", "FBA-28"],
    edit(
        "face.syntax:fap_levels",
        "data.levels = _segment(io, FAP_SEGMENT, models, faps.labels, data.levels, data.tails, 2)",
        "if models:\n        data.levels = _segment(io, FAP_SEGMENT, models, faps.labels, data.levels, data.tails, 2)",
    ),
)
mutant(
    "fba.coder.end-past-data-accepted",
    "A segment that ends past the data is decoded as if zeros followed",
    ["FBA-27"],
    edit(
        _KERNEL,
        "if end - base > cursor.limit << 3:\n        raise OutOfBits",
        "end = min(end, base + (cursor.limit << 3))",
    ),
)
mutant(
    "fba.coder.look-ahead-past-data-refused",
    "The look-ahead of 14 bits must lie inside the data",
    ["FBA-27"],
    edit(_KERNEL, "if end - base > cursor.limit << 3:", "if end + 14 - base > cursor.limit << 3:"),
)
mutant(
    "fba.coder.guard-before-truncation",
    "A bad guard is reported although the segment is cut off",
    ["FBA-27"],
    edit(
        _KERNEL,
        "if end - base > cursor.limit << 3:\n        raise OutOfBits",
        "if end - base > cursor.limit << 3:\n"
        "        if guards and first_bad_guard(start, end, guards, guard_values) >= 0:\n"
        "            return levels, first_bad_guard(start, end, guards, guard_values), 0\n        raise OutOfBits",
    ),
)
mutant(
    "fba.coder.quarter-kept",
    "Straddling intervals are not opened: the middle case of the renormalisation is missing",
    ["FBA-23"],
    edit(_KERNEL, "m = 15 - open_.bit_length() if k < 16 else 0", "m = 0"),
)
mutant(
    "fba.coder.symbol-base",
    "Symbols count from 0, not from the minimum",
    ["FBA-22"],
    edit(_KERNEL, "levels.append(s + model.lo)", "levels.append(s)"),
)
mutant(
    "fba.coder.segment-end-not-reported",
    "A segment that does not end as encoders end it is passed over in silence",
    ["FBA-26", "CNF-23"],
    edit("face.syntax:_segment", "if io.tail:", "if False:"),
    findings=True,
)
