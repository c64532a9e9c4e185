"""Cases on the workers of a Dask cluster.

Rules: CNF-20. Files of the suite travel with the cases by content, and are held against their checksums where they
arrive: workers need this package of the same version, and what an adapter's command names, but no shared folders.

A worker may die: its cases are done again by others. A result counts by decoder and vector, so that none is lost and
none counts twice. A case whose workers die time and again is run once more with no other beside it; if that kills its
workers too it is a crash.
"""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Final
from uuid import uuid4

from snhc.conformance.results import Result
from snhc.reference_impl.bitstream.errors import InputFormat
from snhc.vectors.manifest import Entry

from .case import Case, broken_case, run_case

CONNECT_SECONDS: Final = 10
# Cases that wait at the scheduler, per thread of the cluster: enough to keep it busy, few enough to hold the files of.
AHEAD: Final = 8


def run_cluster(cases: Sequence[Case], suite: Path, address: str, traces: Path | None = None) -> Iterator[Result]:
    """The results of all cases, as they come. Rules: CNF-20.

    Raises InputFormat without Dask, for a worker with another version of this package, OSError for an address that
    does not answer.
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
        try:
            client.wait_for_workers(1, timeout=CONNECT_SECONDS)
        except TimeoutError as error:
            raise OSError(None, "the scheduler has no workers", address) from error
        rest = deque(cases)
        suspects: list[Case] = []
        flight: dict[str, Case] = {}
        pending = as_completed([], loop=client.loop)
        while rest or flight or suspects:
            threads = max(1, sum(client.nthreads().values()))
            # Suspects go alone, when all else is done: then it is clear who kills workers.
            alone = not rest and not flight
            while (rest and len(flight) < AHEAD * threads) or (alone and suspects and not flight):
                case = rest.popleft() if rest else suspects.pop()
                future = client.submit(
                    _on_worker, case, _files(case.entry, suite), str(suite), str(traces or ""), _version(),
                    key=f"snhc-{uuid4().hex}-{case.entry.id}", pure=False,
                )  # fmt: skip
                flight[future.key] = case
                pending.add(future)
            future = next(pending)
            case = flight.pop(future.key)
            try:
                result = future.result()
            except KilledWorker:
                if not alone:
                    suspects.append(case)
                    continue
                result = broken_case(case, suite, "each worker that ran it died")
            finally:
                future.release()
            assert isinstance(result, Result)
            yield result


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
    folder = Path(tempfile.mkdtemp(prefix="snhc-case-"))
    try:
        for name, checksum in files_of(case.entry).items():
            if sha256(files[name]).hexdigest() != checksum:
                raise InputFormat("CNF-20", f"{case.entry.id}: {name}", value="another content", allowed=checksum)
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(files[name])
        return run_case(case, folder, Path(traces) if traces else None, Path(suite))
    finally:
        case.adapter.close()
        shutil.rmtree(folder, ignore_errors=True)
