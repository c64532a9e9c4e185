"""Cases on the cores of this machine.

Rules: CNF-20. Foreign decoders are programs of their own: threads wait for them. The built-in decoder would only wait
for itself, and gets processes; a few vectors are not worth their start.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait as wait_for
from pathlib import Path
from typing import Final

from snhc.conformance.adapters import BuiltIn
from snhc.conformance.process import kill_running
from snhc.conformance.results import Result

from .case import Case, broken_case, run_case

# Below this many seconds of work per process its start costs more than it saves; measured on 2 cores.
FEW: Final = 1000


def run_local(
    cases: Sequence[Case], suite: Path, jobs: int, traces: Path | None = None, few: int = FEW
) -> Iterator[Result]:
    """The results of all cases, as they come. Rules: CNF-20.

    `jobs`: cases at the same time. `few`: so many cases of the built-in decoder need no processes.
    """
    inside = [case for case in cases if isinstance(case.adapter, BuiltIn)]
    outside = [case for case in cases if not isinstance(case.adapter, BuiltIn)]
    if jobs == 1 or len(outside) == 1:
        for case in outside:
            yield run_case(case, suite, traces)
    elif outside:
        yield from _threads(outside, suite, jobs, traces)
    if jobs == 1 or len(inside) <= few:
        for case in inside:
            yield run_case(case, suite, traces)
    else:
        yield from _processes(inside, suite, jobs, traces)


def _threads(cases: Sequence[Case], suite: Path, jobs: int, traces: Path | None) -> Iterator[Result]:
    pool = ThreadPoolExecutor(jobs)
    try:
        futures = [pool.submit(run_case, case, suite, traces) for case in cases]
        waiting = set(futures)
        while waiting:
            done, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    except BaseException:
        # An interrupt: what has not begun does not begin, and what runs is ended.
        pool.shutdown(wait=False, cancel_futures=True)
        kill_running()
        for adapter in {case.adapter.name: case.adapter for case in cases}.values():
            adapter.close()
        raise
    finally:
        pool.shutdown(wait=True)


def _processes(cases: Sequence[Case], suite: Path, jobs: int, traces: Path | None) -> Iterator[Result]:
    rest = deque(cases)
    while rest:
        suspects = yield from _pool(rest, suite, jobs, traces)
        for case in suspects:
            # A worker died, and any of the cases under way can have done it: each gets a process of its own.
            if (yield from _pool(deque([case]), suite, 1, traces)):
                yield broken_case(case, suite, "the process that ran it died")


def _pool(rest: deque[Case], suite: Path, jobs: int, traces: Path | None) -> Generator[Result, None, list[Case]]:
    """Take cases and yield results until all is done or a worker dies; returns what was under way then."""
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(min(jobs, len(rest)), mp_context=context, initializer=_worker)
    flight: dict[Future[Result], Case] = {}
    try:
        while rest or flight:
            # In small portions: of what a dead worker leaves, little is done twice.
            while rest and len(flight) < 2 * jobs:
                flight[pool.submit(run_case, rest[0], suite, traces)] = rest[0]
                rest.popleft()
            done, _ = wait(flight, return_when=FIRST_COMPLETED)
            for future in done:
                result = future.result()
                del flight[future]
                yield result
    except BrokenProcessPool:
        return list(flight.values())
    finally:
        pool.shutdown(wait=True, cancel_futures=True)
    return []


def _worker() -> None:
    # An interrupt is the runner's to handle; and nobody must go on working for one that was killed.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait_for([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
