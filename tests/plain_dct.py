"""A second decoder of DCT payloads, for the tests: DCT-1..7, 9, 10 word by word, on strings of bits.

Nothing here is shared with the codec: the tables are read from their files, words are found by slicing.
"""

from __future__ import annotations

import csv
from math import cos, pi, sqrt
from pathlib import Path

import snhc.reference_impl.tables as shipped

TABLES = Path(shipped.__file__).parent


def words(name: str, folder: Path = TABLES) -> dict[str, int]:
    """Symbols by word."""
    (file,) = folder.glob(f"fap_dct_{name}*.csv")
    with file.open(newline="") as lines:
        return {row["code"]: int(row["symbol"]) for row in csv.DictReader(lines)}


def column(name: str, key: str, value: str) -> dict[int, float]:
    with (TABLES / f"fap_dct_{name}.csv").open(newline="") as lines:
        return {int(row[key]): float(row[value]) for row in csv.DictReader(lines)}


BASE_STEP = column("base_step", "fap", "base_step")
SCALE = column("scale", "fap_quant", "fap_scale")


class PlainPayload:
    """Reads the payloads of one object, one after the other."""

    def __init__(self, bits: str, folder: Path = TABLES) -> None:
        self.bits = bits
        self.at = 0
        self.tables = {
            name: words(name, folder)
            for name in ("viseme_select", "expression_select", "intensity", "runlength", "dc", "ac")
        }
        self.dc: dict[int, int] = {}
        self.viseme = [0, 0, 0]
        self.expression = [0, 0, 0, 0]

    def u(self, n: int) -> int:
        self.at += n
        return int(self.bits[self.at - n : self.at], 2)

    def s(self, n: int) -> int:
        value = self.u(n)
        return value - 2**n if value >= 2 ** (n - 1) else value

    def vlc(self, name: str) -> int:
        n = 1
        while self.bits[self.at : self.at + n] not in self.tables[name]:
            n += 1
            assert n <= 32
        self.at += n
        return self.tables[name][self.bits[self.at - n : self.at]]

    def payload(
        self, at: int, coded: list[int], intra: bool
    ) -> tuple[list[list[int]], list[list[int]], dict[int, list[int]]]:
        """(viseme, expression: 16 rows with their flags; by FAP the 16 coefficients, DC as value); `at` moves on."""
        self.at = at
        visemes, expressions = [], []
        if 1 in coded:
            for t in range(16):
                if intra and t == 0:
                    self.viseme = [self.u(4), self.u(4), self.u(6)]
                else:
                    differences = [self.vlc("viseme_select") - 14, self.vlc("viseme_select") - 14,
                                   self.vlc("intensity") - 63]  # fmt: skip
                    self.viseme = [a + b for a, b in zip(self.viseme, differences, strict=True)]
                visemes.append([*self.viseme, self.u(1)])
        if 2 in coded:
            for t in range(16):
                if intra and t == 0:
                    self.expression = [self.u(4), self.u(4), self.u(6), self.u(6)]
                else:
                    differences = [self.vlc("expression_select") - 6, self.vlc("expression_select") - 6,
                                   self.vlc("intensity") - 63, self.vlc("intensity") - 63]  # fmt: skip
                    self.expression = [a + b for a, b in zip(self.expression, differences, strict=True)]
                expressions.append([*self.expression, self.u(1), self.u(1)])
        return visemes, expressions, {fap: self.coefficients(fap, intra) for fap in coded if fap > 2}

    def coefficients(self, fap: int, intra: bool) -> list[int]:
        out = [0] * 16
        if intra:
            out[0] = self.wide_or_not()
        else:
            symbol = self.vlc("dc")
            difference = symbol - 256
            if symbol == 0:
                difference = self.s(16)
                if difference == -32768:
                    difference = self.s(32)
            out[0] = self.dc[fap] + difference
        self.dc[fap] = out[0]
        k = 0
        while k < 15:
            run = self.vlc("runlength")
            if run == 15:
                break
            k = k + 1 + run
            symbol = self.vlc("ac")
            out[k] = self.wide_or_not() if symbol == 256 else symbol - 256
        return out

    def wide_or_not(self) -> int:
        value = self.s(16)
        return self.s(31) if value == -256 * 128 else value


def values(fap: int, quant: int, coefficients: list[int]) -> list[float]:
    """16 values before rounding (DCT-5, DCT-6, DCT-7)."""
    step = SCALE[quant] * BASE_STEP[fap]
    f = [coefficients[0] * step / 3, *[c * step for c in coefficients[1:]]]
    return [
        sum(sqrt((2 if k else 1) / 16) * f[k] * cos((2 * t + 1) * k * pi / 32) for k in range(16)) for t in range(16)
    ]
