"""Cases on the workers of a Dask cluster.

Rules: CNF-20. Files of the suite travel with the cases by content, and are held against their checksums where they
arrive: workers need this package of the same version, and what an adapter's command names, but no shared folders.

A worker may die: its cases are done again by others. A result counts by decoder and vector, so that none is lost and
none counts twice. A case that outlives no worker, also when it is the only one, is a crash.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Final

from snhc.conformance.results import Result
from snhc.conformance.scratch import scratch
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import Entry

from .case import Case, broken_case, run_case

if TYPE_CHECKING:
    from distributed import Client, as_completed

CONNECT_SECONDS: Final = 10
# Cases that wait at the scheduler, per thread of the cluster: enough to keep it busy, few enough to hold the files of.
AHEAD: Final = 8
# How long a run waits for a worker when there is none: those of a queue may only be on their way.
ALONE_SECONDS: Final = 120.0
_LOOK_SECONDS: Final = 1.0
_PAUSE: Final = 0.01


def run_cluster(cases: Sequence[Case], suite: Path, address: str, traces: Path | None = None) -> Iterator[Result]:
    """The results of all cases, as they come. Rules: CNF-20.

    Raises InputFormat without Dask, for a worker with another version of this package, OSError for an address that
    does not answer, and where the cluster has no worker for ALONE_SECONDS.
    """
    try:
        from distributed import Client, as_completed
        from distributed.scheduler import KilledWorker
    except ImportError as error:
        raise InputFormat(
            "CNF-20",
            "--cluster",
            value="dask.distributed is not installed",
            allowed="the extra: pip install snhc[cluster]",
        ) from error
    try:
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise OSError(None, f"no Dask scheduler answers: {error}", address) from error
    with contextlib.closing(client):
        version = _version()
        rest = iter(cases)
        flight: dict[str, Case] = {}
        pending = as_completed([], loop=client.loop)

        submitted: list[str] = []
        # Dask blames every case that a dead worker had before it, not only the one that took it down. These are run
        # again when all others are done, one after the other, so that the blame falls on the right one.
        suspects: list[Case] = []

        def submit(case: Case) -> None:
            key = f"snhc-{len(submitted)}-{case.entry.id}"
            future = client.submit(
                _on_worker, case, _files(case.entry, suite), str(suite), str(traces or ""), version, key=key,
                pure=False,
            )  # fmt: skip
            submitted.append(key)
            flight[future.key] = case
            pending.add(future)

        def more() -> None:
            threads = max(1, sum(client.nthreads().values()))
            while len(flight) < AHEAD * threads and (case := next(rest, None)) is not None:
                submit(case)

        more()
        while flight or suspects:
            alone = not flight
            if alone:
                submit(suspects.pop(0))
            _await(client, pending, address)
            future = next(pending)
            case = flight.pop(future.key)
            if future.cancelled():
                raise OSError(None, "the Dask scheduler has given the run up", address)
            fault = future.exception()
            if fault is None:
                result = future.result()
            elif isinstance(fault, KilledWorker) and alone:
                result = broken_case(case, suite, "each worker that ran it died")
            elif isinstance(fault, KilledWorker):
                result = None
                suspects.append(case)
            else:
                raise fault
            future.release()
            if result is not None:
                assert isinstance(result, Result)
                yield result
            more()


def _await(client: Client, pending: as_completed, address: str) -> None:
    """Wait for the next result as long as there are workers, or some may still come."""
    seen = looked = time.monotonic()
    while not pending.has_ready():
        time.sleep(_PAUSE)
        now = time.monotonic()
        if now - looked < _LOOK_SECONDS:
            continue
        looked = now
        if client.nthreads():
            seen = now
        elif now - seen > ALONE_SECONDS:
            raise OSError(None, f"the Dask cluster has had no worker for {ALONE_SECONDS:g} s", address)


def _version() -> str:
    from importlib.metadata import version

    return version("snhc")


def _files(entry: Entry, suite: Path) -> dict[str, bytes]:
    from snhc.conformance.runner import files_of

    return {name: (suite / name).read_bytes() for name in files_of(entry)}


def _on_worker(case: Case, files: Mapping[str, bytes], suite: str, traces: str, version: str) -> Result:
    from snhc.conformance.runner import files_of

    if _version() != version:
        raise InputFormat("CNF-20", "snhc on the worker", value=_version(), allowed=f"version {version}")
    with scratch() as folder, contextlib.closing(case.adapter):
        for name, checksum in files_of(case.entry).items():
            if sha256(files[name]).hexdigest() != checksum:
                raise InputFormat("CNF-20", f"{case.entry.id}: {name}", value="another content", allowed=checksum)
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(files[name])
        return run_case(case, folder, Path(traces) if traces else None, Path(suite))
