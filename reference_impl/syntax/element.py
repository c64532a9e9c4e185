"""Elements of the syntax, faults that relations between them can have, and the readings in force.

Rules: CNF-7, CNF-21, CNF-24.

An element is declared once, with its rule and domain; the declaration feeds the reader, the writers, the tracer, the
dump and the docs.
"""

from __future__ import annotations

from typing import Final, final

from ..bitstream.errors import (
    ForbiddenValue,
    MarkerBit,
    SnhcError,
)


@final
class Element:
    """A named syntax element: rule, domain, and what its values mean.

    Rules: CNF-7, CNF-21.

    `name`: the standard's spelling. `lo`, `hi`: the allowed values where the width allows more (None: all).
    `forbidden`: single values inside that are not allowed. `fault`: the error class of a value outside the domain.
    `domain_rule`: the rule that such a value breaks, where it is not `rule`. `meaning`: value -> words, for people.
    `fixed`: a bit pattern that the syntax prescribes (start codes, stuffing): there is nothing to choose.
    `index`: place in `ELEMENTS`, by which traces name it.
    """

    __slots__ = (
        "domain_rule", "fault", "fixed", "forbidden", "hi", "index", "lo", "meaning", "name", "restricted", "rule",
    )  # fmt: skip

    def __init__(
        self,
        name: str,
        rule: str,
        *,
        lo: int | None = None,
        hi: int | None = None,
        forbidden: tuple[int, ...] = (),
        fault: type[SnhcError] = ForbiddenValue,
        domain_rule: str = "",
        meaning: dict[int, str] | None = None,
        fixed: bool = False,
    ) -> None:
        self.name = name
        self.rule = rule
        self.lo = lo
        self.hi = hi
        self.forbidden = forbidden
        self.fault = fault
        self.domain_rule = domain_rule or rule
        self.meaning = meaning if meaning is not None else {}
        self.fixed = fixed
        self.restricted = lo is not None or hi is not None or bool(forbidden)
        self.index = len(ELEMENTS)
        ELEMENTS.append(self)

    def allows(self, value: int) -> bool:
        """Whether a value lies in the domain. Rules: CNF-7."""
        if self.lo is not None and value < self.lo:
            return False
        if self.hi is not None and value > self.hi:
            return False
        return value not in self.forbidden

    @property
    def allowed(self) -> str:
        """The domain in words, for messages. Rules: CNF-7."""
        if self.lo is not None and self.hi is not None:
            if self.hi - self.lo <= 8:
                return ", ".join(str(v) for v in range(self.lo, self.hi + 1) if v not in self.forbidden)
            text = f"{self.lo}..{self.hi}"
        elif self.lo is not None:
            text = f"{self.lo} or more"
        elif self.hi is not None:
            text = f"at most {self.hi}"
        else:
            text = "any value"
        if self.forbidden:
            text += " but " + ", ".join(map(str, self.forbidden))
        return text


ELEMENTS: Final[list[Element]] = []


def marker(rule: str) -> Element:
    """A `marker_bit` of the given rule. Rules: CNF-7."""
    return Element("marker_bit", rule, lo=1, hi=1, fault=MarkerBit)


@final
class Fault:
    """A relation that must hold, declared once. Rules: CNF-7.

    `what`: the element or relation that is at fault; `allowed`: what would be right. `declared`: the fault in `FAULTS`
    that this one was made from by `allowing`, else itself.
    """

    __slots__ = ("allowed", "declared", "error", "rule", "what")

    def __init__(
        self, error: type[SnhcError], rule: str, what: str, allowed: str, declared: Fault | None = None
    ) -> None:
        self.error = error
        self.rule = rule
        self.what = what
        self.allowed = allowed
        self.declared: Fault = self if declared is None else declared
        if declared is None:
            FAULTS.append(self)

    def allowing(self, allowed: str, what: str = "") -> Fault:
        """The same fault where only the stream tells what is allowed, or which one it is. Rules: CNF-7."""
        return Fault(self.error, self.rule, what or self.what, allowed, self.declared)


FAULTS: Final[list[Fault]] = []


@final
class Step:
    """A level of the path: `plane`, `group`, ... Rules: CNF-21."""

    __slots__ = ("index", "name")

    def __init__(self, name: str) -> None:
        self.name = name
        self.index = len(STEPS)
        STEPS.append(self)


STEPS: Final[list[Step]] = []


@final
class Readings:
    """Which reading of each ambiguity is followed; one attribute per choice, the defaults are the register's.

    Rules: CNF-24.
    """

    __slots__ = (
        "bap_base_step", "chosen", "clipping", "dc_step_ratio", "dct_intensity", "default_range_47",
        "empty_plane_header", "end_after_last", "expression_order", "limits_after_quant", "mask_order",
        "mesh_split", "mesh_ties", "normalisation", "skipped_frames", "trailing_zeros", "unstuffed_plane",
    )  # fmt: skip

    def __init__(self, chosen: dict[str, str] | None = None) -> None:
        self.chosen: dict[str, str] = dict(sorted(chosen.items())) if chosen else {}
        get = self.chosen.get
        self.mask_order = get("AMB-FBA-1", "lowest-first")
        self.default_range_47 = get("AMB-FBA-2", "table")
        self.limits_after_quant = get("AMB-FBA-3", "rederived")
        self.clipping = get("AMB-FBA-4", "none")
        self.bap_base_step = get("AMB-FBA-5", "base_step")
        self.skipped_frames = get("AMB-FBA-6", "after")
        self.empty_plane_header = get("AMB-FBA-7", "header")
        self.unstuffed_plane = get("AMB-FBA-8", "accept")
        self.trailing_zeros = get("AMB-FBA-9", "padding")
        self.dc_step_ratio = int(get("AMB-DCT-1", "3"))
        self.normalisation = get("AMB-DCT-2", "orthonormal")
        self.dct_intensity = get("AMB-DCT-3", "unscaled")
        self.end_after_last = get("AMB-DCT-4", "none")
        self.expression_order = get("AMB-DCT-5", "segments")
        self.mesh_split = get("AMB-MSH-1", "checkerboard")
        self.mesh_ties = get("AMB-MSH-2", "fan")


DEFAULT_READINGS: Final = Readings()
