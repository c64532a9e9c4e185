"""Prints what it once decoded, whatever it is asked for."""

import sys

from _shared import SUITE

sys.stdout.write((SUITE / "fap" / "fap.arith.example.2.ndjson").read_text())
