"""An independent second parser of mesh objects, for tests only: strings of bits, no class of the product.

It shares the tables' CSV files with the product, nothing else.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

TABLES = Path(__file__).resolve().parents[2] / "reference_impl" / "tables"
SAMPLES = Path(__file__).resolve().parents[1] / "fixtures" / "samples"


@dataclass
class Plane:
    intra: bool
    nodes: list[tuple[int, int]] | None = None
    uniform: tuple[int, int, int, int, int] | None = None
    boundary_count: int = 0
    range_code: int = 0
    codes: list[tuple[int, int, int, int, int]] = field(default_factory=list)


def _words(name: str, value: str) -> dict[str, int]:
    with (TABLES / name).open(encoding="utf-8", newline="") as lines:
        return {row["code"]: int(row[value]) for row in csv.DictReader(lines)}


class _Bits:
    def __init__(self, data: bytes) -> None:
        self.text = "".join(f"{byte:08b}" for byte in data)
        self.at = 0
        self.length = _words("mesh_delta_len.csv", "delta_len")
        self.mvd = _words("mvd.csv", "vlc_value")

    def u(self, n: int) -> int:
        assert self.at + n <= len(self.text)
        word = self.text[self.at : self.at + n]
        self.at += n
        return int(word, 2) if n else 0

    def vlc(self, table: dict[str, int]) -> int:
        for n in range(1, 14):
            word = self.text[self.at : self.at + n]
            if word in table:
                self.at += n
                return table[word]
        raise AssertionError(self.text[self.at : self.at + 13])

    def delta(self) -> int:
        n = self.vlc(self.length)
        if n == 0:
            return 0
        code = self.u(n)
        return code if code >> (n - 1) else code - (1 << n) + 1


def _temporal_header(bits: _Bits, intra: bool) -> None:
    if intra and bits.u(1):
        bits.u(13)
    if intra and bits.u(1):
        bits.u(18)
    if bits.u(1):
        while bits.u(4) == 15:
            pass


def parse(data: bytes) -> list[Plane]:
    """The planes of a valid stream, geometry without its triangles, motion without its vectors."""
    bits = _Bits(data)
    assert bits.u(32) == 0x1BC
    planes: list[Plane] = []
    node_count = 0
    while True:
        if bits.text[bits.at : bits.at + 8] == "01111111":
            bits.u(8)
        while bits.text[bits.at :].startswith(f"{0x1B2:032b}"):
            bits.at += 32
            while not bits.text[bits.at :].startswith(f"{1:024b}"):
                bits.u(8)
        if bits.at + 32 > len(bits.text) or bits.u(32) != 0x1BD:
            return planes
        plane = Plane(intra=bool(bits.u(1)))
        planes.append(plane)
        mask = bits.u(1)
        _temporal_header(bits, plane.intra)
        if mask and plane.intra:
            _geometry(bits, plane)
            node_count = len(plane.nodes or ())
        elif mask:
            plane.range_code = bits.u(3)
            for _ in range(node_count):
                if bits.u(1):
                    plane.codes.append((1, 0, 0, 0, 0))
                    continue
                pair = []
                for _ in range(2):
                    vlc = bits.vlc(bits.mvd)
                    pair += [vlc, bits.u(plane.range_code - 1) if vlc else 0]
                plane.codes.append((0, pair[0], pair[1], pair[2], pair[3]))
        # Stuffing: 0 and then 1s to the byte boundary.
        n = 8 - bits.at % 8
        if bits.at < len(bits.text):
            assert bits.u(n) == (1 << (n - 1)) - 1


def _geometry(bits: _Bits, plane: Plane) -> None:
    if bits.u(2) == 1:
        hor, vert = bits.u(10), bits.u(10)
        assert bits.u(1) == 1
        width, height, split = bits.u(8), bits.u(8), bits.u(2)
        plane.uniform = (hor, vert, width, height, split)
        plane.nodes = [(c * width, r * height) for r in range(vert) for c in range(hor)]
        return
    count = bits.u(16)
    assert bits.u(1) == 1
    plane.boundary_count = bits.u(10)
    assert bits.u(1) == 1
    first = []
    for _ in range(2):
        value = bits.u(13)
        first.append(value - (value >> 12 << 13))
        assert bits.u(1) == 1
    x, y = first
    plane.nodes = [(x, y)]
    for _ in range(count - 1):
        x += bits.delta()
        y += bits.delta()
        plane.nodes.append((x, y))


def sample_names() -> list[str]:
    return sorted(f"{kind}/{path.name}" for kind in ("mesh", "meshtie") for path in (SAMPLES / kind).iterdir())


def sample(name: str) -> tuple[list[Plane], list[dict[str, Any]]]:
    folder = SAMPLES / name
    text = (folder / "expected.ndjson").read_text(encoding="utf-8")
    lines = [json.loads(line) for line in text.splitlines()]
    return parse((folder / "input.m2d").read_bytes()), lines[1:]
