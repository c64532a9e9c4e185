"""FAP units (FAPU).

Rules: FAC-1 (the units; the unit of a FAP is the column `unit` of tables/fap_table.csv). The distances
themselves are measured in `face_definition`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

from snhc.reference_impl.tables import fap_table

AU: Final = 1e-5
UNIT_NAMES: Final = ("ES", "ENS", "MNS", "MW", "IRISD")
UNITS_PER_DISTANCE: Final = 1024


@dataclass(frozen=True, slots=True)
class Fapu:
    """The units themselves (distance / 1024), in model units; None where a document gives none.

    Rules: FAC-1. AU is a constant, in radians.
    """

    es: float | None = None
    ens: float | None = None
    mns: float | None = None
    mw: float | None = None
    irisd: float | None = None

    def unit(self, name: str) -> float | None:
        """The value of one unit of the FAP table; "na" (FAP 1 and 2) is 1.

        Rules: FAC-1, FAT-8. `name`: ES, ENS, MNS, MW, IRISD, AU or na. None: not given.
        """
        match name:
            case "ES":
                return self.es
            case "ENS":
                return self.ens
            case "MNS":
                return self.mns
            case "MW":
                return self.mw
            case "IRISD":
                return self.irisd
            case "AU":
                return AU
            case _:
                return 1.0


@cache
def fap_unit_names() -> tuple[str, ...]:
    """Unit name of every FAP, entry i is FAP i + 1 (68 entries).

    Rules: FAC-1, FAC-4.
    """
    return tuple(record.unit for record in fap_table())
