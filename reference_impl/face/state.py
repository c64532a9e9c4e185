"""The decoder's state: what stays in force from plane to plane.

Rules: FBA-14, FBA-15, FBA-17, FBA-18, FBA-19, FBA-30, FBA-31, FBA-34, FBA-40.
"""

from __future__ import annotations

from typing import final

from ..entropy.model import Model
from ..syntax.element import Readings
from ..syntax.temporal import Clock
from .parameters import I_MAX, I_MIN, LIMIT_UNIT, P_MAX, P_MIN, SIGNS, ParameterSet, bap_set, fap_set, high_level_limits
from .records import ParameterData


@final
class ParameterState:
    """Masks, quantiser, ranges, models and values of the FAPs 3..68 or the BAPs.

    Rules: FBA-14, FBA-15, FBA-17, FBA-19, FBA-30, FBA-31.

    `selected`: coded parameters in coding order; `steps`, `labels`, `i_models`, `p_models` go with it. `limits`: per
    list and number the limit at quantiser 1; `in_force`: divided (FBA-17). `values`, `decoded`: by number.
    """

    __slots__ = (
        "coding_type", "decoded", "divided", "has_intra", "i_models", "in_force", "labels", "limits", "p_models",
        "parameters", "quant", "scale", "selected", "steps", "values",
    )  # fmt: skip

    def __init__(self, parameters: ParameterSet) -> None:
        size = parameters.count + 1
        self.parameters = parameters
        self.has_intra = False
        self.quant = 0
        self.scale = 0
        self.coding_type = 0
        self.selected: list[int] = []
        self.labels: list[str] = []
        self.steps: list[int] = []
        self.limits: list[list[int]] = [list(defaults) for defaults in parameters.defaults]
        self.in_force: list[list[int]] = [[0] * size for _ in range(4)]
        self.divided: list[list[bool]] = [[False] * size for _ in range(4)]
        self.i_models: list[Model] = []
        self.p_models: list[Model] = []
        self.values = [0] * size
        self.decoded = [False] * size

    def select(self, data: ParameterData, readings: Readings) -> list[tuple[int, int]]:
        """Put the masks and the quantiser of an intra plane in force.

        Rules: FBA-10, FBA-14, FBA-15, FBA-31. Returns the parameters that are *not* coded, as (number, mask type).
        """
        highest_first = readings.mask_order == "highest-first"
        selected: list[int] = []
        others: list[tuple[int, int]] = []
        for g, group in enumerate(self.parameters.groups):
            mask_type = data.mask_type[g]
            if mask_type == 3:
                selected += group
                continue
            mask = data.group_mask[g] if mask_type else 0
            last = len(group) - 1
            for i, number in enumerate(group):
                if (mask >> (i if highest_first else last - i)) & 1:
                    selected.append(number)
                else:
                    others.append((number, mask_type))
        self.quant = data.quant
        self.scale = self.parameters.quant_scale[data.quant]
        self.coding_type = data.coding_type
        self.selected = selected
        return others

    def set_ranges(self, data: ParameterData, readings: Readings) -> None:
        """Put the limits that were sent in force, and make the models anew.

        Rules: FBA-17, FBA-19, FBA-30, FBA-31.
        """
        divisor = self.scale if self.scale else 1
        kept = readings.limits_after_quant == "kept"
        for which in (I_MAX, I_MIN, P_MAX, P_MIN):
            limits = self.limits[which]
            in_force = self.in_force[which]
            divided = self.divided[which]
            sent = data.new[which]
            if sent:
                v = data.limits[which]
                unit = SIGNS[which] * LIMIT_UNIT
                for number in self.selected:
                    limits[number] = v[number] * unit
            for number in self.selected:
                if kept and divided[number] and not sent:
                    continue
                limit = limits[number]
                # Truncation toward zero, as everywhere (FBA-17).
                in_force[number] = limit // divisor if limit >= 0 else -(-limit // divisor)
                divided[number] = True
        i_max, i_min, p_max, p_min = self.in_force
        self.i_models = [Model(i_min[number], i_max[number], False) for number in self.selected]
        self.p_models = [Model(p_min[number], p_max[number], True) for number in self.selected]
        self.set_steps()

    def set_steps(self) -> None:
        """Steps and labels of the selected parameters. Rules: FBA-31."""
        base_steps = self.parameters.base_steps
        self.steps = [base_steps[number] * self.scale if self.scale else 1 for number in self.selected]
        self.labels = [self.parameters.labels[number] for number in self.selected]


@final
class FaceState:
    """Everything that one FBA object keeps. Rules: FBA-15, FBA-29, FBA-30, FBA-34, FBA-38.

    `viseme`: select1, select2, blend, def; `expression`: select1, intensity1, select2, intensity2, init_face, def:
    the last reconstructed ones. `letters_with_data`, `letters_without`: the states after a plane with and without
    FAP data.
    """

    __slots__ = (
        "_baps", "clock", "dct_dc", "dct_expression", "dct_viseme", "expression", "faps", "has_expression",
        "has_viseme", "high_i_models", "high_p_models", "index", "letters_with_data", "letters_without", "readings",
        "seen_dct", "seen_expression", "seen_viseme", "shown", "viseme",
    )  # fmt: skip

    def __init__(self, readings: Readings) -> None:
        self.readings = readings
        self.clock = Clock()
        self.faps = ParameterState(fap_set(readings.default_range_47))
        self._baps: ParameterState | None = None
        self.index = 0
        self.has_viseme = False
        self.has_expression = False
        self.seen_viseme = False
        self.seen_expression = False
        self.viseme = [0, 0, 0, 0]
        self.expression = [0, 0, 0, 0, 0, 0]
        # Predictors of DCT segments: values of the last instant, quantised DC by FAP (DCT-3, DCT-9, DCT-11).
        self.seen_dct = False
        self.dct_viseme = [0, 0, 0]
        self.dct_expression = [0, 0, 0, 0]
        self.dct_dc = [0] * 69
        self.high_i_models: list[Model] = []
        self.high_p_models: list[Model] = []
        self.letters_with_data = "U" * 68
        self.letters_without = "U" * 68
        self.shown: list[int] = []

    @property
    def baps(self) -> ParameterState:
        """The bodies' part, made when first asked for: most streams have none. Rules: FBA-40."""
        if self._baps is None:
            self._baps = ParameterState(bap_set(self.readings.bap_base_step))
        return self._baps

    def select_faps(self, data: ParameterData) -> None:
        """Put the masks of an intra plane in force, and the state letters that follow from them.

        Rules: FBA-14, FBA-15, FBA-34.
        """
        faps = self.faps
        others = faps.select(data, self.readings)
        selected = faps.selected
        self.has_viseme = 1 in selected
        self.has_expression = 2 in selected
        decoded = faps.decoded
        for number in selected:
            decoded[number] = True
        self.seen_viseme = self.seen_viseme or self.has_viseme
        self.seen_expression = self.seen_expression or self.has_expression
        faps.selected = [number for number in selected if number > 2]
        letters = ["T"] * 68
        for number, mask_type in others:
            letters[number - 1] = "I" if mask_type == 2 else "R" if decoded[number] else "U"
        self.letters_with_data = "".join(letters)
        self.letters_without = self.letters_with_data.replace("T", "R")
        self.shown = [number for number in range(3, 69) if letters[number - 1] in "TR"]

    def set_high_level_models(self) -> None:
        """New models for the seven symbols of FAP 1 and 2. Rules: FBA-29, FBA-30."""
        intra, inter = high_level_limits(self.faps.quant)
        self.high_i_models = [Model(lo, hi, False) for lo, hi in intra]
        self.high_p_models = [Model(lo, hi, True) for lo, hi in inter]
