"""Shards: `i/n`, the part of a run that one job of a CI matrix does.

Rules: CNF-20. Law: every vector is in exactly one of the n shards, and their sizes differ by at most one.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from snhc.reference_impl.bitstream.errors import InputFormat

_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class Shard:
    """The shard `number` (from 1) of `count`. Rules: CNF-20."""

    number: int
    count: int

    def of(self, entries: Sequence[_T]) -> list[_T]:
        """Its part. Neighbours, which are of one tool and cost alike, go to different shards. Rules: CNF-20."""
        return list(entries[self.number - 1 :: self.count])

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def parse_shard(text: str) -> Shard:
    """`2/3`: the second of three. Rules: CNF-20. Raises InputFormat."""
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise InputFormat("CNF-20", "shard", value=text, allowed="i/n with i from 1 to n")
    return Shard(int(match[1]), int(match[2]))
