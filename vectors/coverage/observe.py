"""Running the suite through the probe and the watched decoder: which vector reaches which cell.

Rules: CNF-8, CNF-22, CNF-24. Everything is decoded once before it is watched, so that what is computed once and kept
(tables) does not depend on what ran before.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from snhc.reference_impl.bitstream.errors import ERROR_CLASSES, ResourceLimit, SnhcError
from snhc.reference_impl.bitstream.limits import Limits
from snhc.reference_impl.entropy.prefix import PrefixTable
from snhc.reference_impl.syntax.element import DEFAULT_READINGS, Element, Readings
from snhc.reference_impl.systems.stream import Options

from ..decoding import Decoded, decode_input
from ..manifest import DOCUMENTS, Accepted, Entry, Rejected
from .branches import Source, Watch, modules, read_source
from .cells import Cell, learn, name_of, universe
from .probe import Met, probe

_NO_LIMIT: Final = 1 << 60


@dataclass(frozen=True, slots=True)
class Observation:
    """What a suite reaches.

    Rules: CNF-8. `cells`: all, by key; `hits`: key -> ids of vectors, of those reached; `unentered`: modules of the
    codec in which no vector takes a branch: encoders and outputs, which are no part of the decoder.
    """

    cells: Mapping[str, Cell]
    hits: Mapping[str, frozenset[str]]
    unentered: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class _Run:
    """One decoding of a vector: the options that it takes, and the reading."""

    entry: Entry
    data: bytes
    aux: bytes | None
    options: Options

    def decode(self, limits: Limits | None = None) -> Decoded:
        options = self.options if limits is None else replace(self.options, limits=limits)
        return decode_input(self.entry.media, self.data, self.aux, options)


def sources_of(outside: Callable[[str], bool]) -> tuple[Source, ...]:
    """The modules of the decoder, `outside` left out. Rules: CNF-8."""
    return tuple(read_source(name, ERROR_CLASSES) for name in modules() if not outside(name))


def observe(entries: Iterable[Entry], suite: Path, sources: Iterable[Source]) -> Observation:
    """Decode vectors and see which cells they reach. Rules: CNF-8.

    `sources`: the modules whose branches count. Takes a few seconds for a thousand vectors.
    """
    sources = tuple(sources)
    runs = [run for entry in entries for run in _runs(entry, suite)]
    hits: dict[str, set[str]] = {}

    def hit(key: str, run: _Run) -> None:
        hits.setdefault(key, set()).add(run.entry.id)

    met: dict[str, set[Met]] = {}
    elements: dict[str, Element] = {}
    tables: dict[str, PrefixTable] = {}
    for run in runs:
        for key in _of_run(run, run.decode()):
            hit(key, run)
        if run.entry.media not in DOCUMENTS:
            seen = probe(run.data, run.options)
            met.setdefault(run.entry.id, set()).update(seen.met)
            elements |= seen.elements
            tables |= seen.tables
    learnt = learn((one for found in met.values() for one in found), elements, tables)
    for id, found in met.items():
        for one in found:
            for key in name_of(one, learnt):
                hits.setdefault(key, set()).add(id)
    if sources:
        for key, ids in Watch(sources).run([(run.entry.id, run.decode) for run in runs]).items():
            hits.setdefault(key, set()).update(ids)
    entered = [source for source in sources if any(branch.key in hits for branch in source.branches)]
    cells = universe(learnt, entered)
    for key in hits:
        # Rules of errors that are raised through a helper do not stand in one place of the source.
        cells.setdefault(key, Cell(key, tuple(word for word in key.split("/")[2:3] if key.startswith("error/"))))
    unentered = tuple(source.module for source in sources if source.branches and source not in entered)
    return Observation(cells, {key: frozenset(ids) for key, ids in hits.items()}, unentered)


def _runs(entry: Entry, suite: Path) -> list[_Run]:
    data = (suite / entry.file).read_bytes()
    aux = (suite / entry.aux).read_bytes() if entry.aux else None
    readings = [DEFAULT_READINGS]
    readings += [Readings({amb: key}) for amb, expects in entry.readings.items() for key in expects]
    return [_Run(entry, data, aux, entry.options.for_decoder(one)) for one in readings]


def _of_run(run: _Run, decoded: Decoded) -> list[str]:
    """The cells of a decoding that the outcome and the manifest tell."""
    entry = run.entry
    out = [f"rule/{rule}/named" for rule in entry.rules]
    for expect in (entry.expect, *(one for expects in entry.readings.values() for one in expects.values())):
        if isinstance(expect, Rejected):
            out.append(f"rule/{expect.rule}/broken")
    out += [f"finding/{finding.id}" for finding in decoded.findings]
    out += [f"reading/{amb}/{key}" for amb, key in run.options.readings.chosen.items()]
    if decoded.error is not None:
        out.append(f"error/{decoded.error.error_class}/{decoded.error.rule}")
    out += _limits(run, decoded.error)
    return out


def _limits(run: _Run, error: SnhcError | None) -> list[str]:
    """Which limit is passed, or just not: found by moving one limit at a time and decoding again."""
    limits = run.options.limits
    if isinstance(error, ResourceLimit):
        raised = [name for name in Limits.names() if _differs(run, limits, name, _NO_LIMIT)]
        return [f"limit/{name}/passed" for name in raised]
    if not isinstance(run.entry.expect, Accepted):
        return []
    return [
        f"limit/{name}/reached"
        for name, value in run.entry.options.limits.items()
        if isinstance(run.decode(limits.with_values({name: value - 1})).error, ResourceLimit)
    ]


def _differs(run: _Run, limits: Limits, name: str, value: int) -> bool:
    error = run.decode(limits.with_values({name: value})).error
    return not isinstance(error, ResourceLimit)
