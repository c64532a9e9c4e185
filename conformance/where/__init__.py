"""Where a decoder went wrong, and what a report shows of it.

Rules: CNF-17, CNF-18, CNF-21, CNF-25. The form of the evidence is in `reports/report.schema.json`.
"""

from .examine import Findings, examine
from .location import Hit, Location, find, find_bits, locate

__all__ = ["Findings", "Hit", "Location", "examine", "find", "find_bits", "locate"]
