"""Reports joined: shards of one run, and several decoders side by side.

Rules: CNF-18, CNF-20. Law: the shards of a run join to the report of the unbroken run, but for seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from snhc.conformance.results import Note, Report, Result, Shards
from snhc.reference_impl.bitstream.errors import InputFormat


def merge(reports: Sequence[Report], names: Sequence[str]) -> Report:
    """One report of all. Rules: CNF-18, CNF-20. `names`: what to call each report in errors.

    Raises InputFormat for another suite, for shards of different runs, and for a vector that two reports judge
    differently.
    """
    first = reports[0]
    adapters: dict[str, None] = {}
    results: dict[tuple[str, str], tuple[Result, str]] = {}
    filters: dict[str, None] = {}
    notes: dict[Note, None] = {}
    for report, name in zip(reports, names, strict=True):
        if (report.suite, report.digest) != (first.suite, first.digest):
            raise InputFormat(
                "CNF-20", name, value=f"suite {report.suite} ({report.digest[:12]})",
                allowed=f"the suite of {names[0]}: {first.suite} ({first.digest[:12]})",
            )  # fmt: skip
        adapters |= dict.fromkeys(report.adapters)
        filters |= dict.fromkeys([report.filter])
        notes |= dict.fromkeys(report.notes)
        for result in report.results:
            known = results.get(result.key)
            if known is not None and replace(known[0], seconds=0.0) != replace(result, seconds=0.0):
                raise InputFormat(
                    "CNF-20", f"{name}: {result.vector} [{result.adapter}]", value=result.status,
                    allowed=f"the same result as in {known[1]}: {known[0].status}",
                )  # fmt: skip
            results.setdefault(result.key, (result, name))
    order = {adapter: number for number, adapter in enumerate(adapters)}
    return Report(
        first.suite,
        "; ".join(filters),
        tuple(adapters),
        tuple(
            result for result, _ in sorted(results.values(), key=lambda item: (order[item[0].adapter], item[0].vector))
        ),
        first.digest,
        _shards(reports, names),
        tuple(notes),
    )


def _shards(reports: Sequence[Report], names: Sequence[str]) -> dict[str, Shards]:
    """By adapter, those that are not all there."""
    found: dict[str, Shards] = {}
    whole: set[str] = set()
    filters: dict[str, tuple[str, str]] = {}
    for report, name in zip(reports, names, strict=True):
        for adapter in report.adapters:
            shards = report.shards.get(adapter)
            if shards is None:
                whole.add(adapter)
                continue
            before = found.get(adapter, Shards(shards.count, ()))
            filter, where = filters.setdefault(adapter, (report.filter, name))
            if before.count != shards.count or filter != report.filter:
                raise InputFormat(
                    "CNF-20", f"{name}: shards of {adapter}", value=f"of {shards.count}, filter {report.filter!r}",
                    allowed=f"as in {where}: of {before.count}, filter {filter!r}",
                )  # fmt: skip
            found[adapter] = Shards(shards.count, tuple(sorted({*before.present, *shards.present})))
    return {adapter: shards for adapter, shards in found.items() if adapter not in whole and shards.missing}
