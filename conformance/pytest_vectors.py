"""One test per vector and adapter file, for the pytest plugin.

Rules: CNF-13, CNF-15, CNF-17, CNF-19.

The adapter file is the collector: tests are called `my-decoder.toml::ID`. Each has the marker `snhc`, one of its tier
(`snhc_error`), and its rules as keywords (`-k FBA-26`). What a decoder does not claim is skipped, a known failure of
the ledger is expected to fail. With no pass among them, the run fails.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from datetime import date
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from snhc.reference_impl.bitstream.errors import SnhcError, one_line
from snhc.vectors.manifest import SUITE, TIERS, Entry, Manifest, load

from . import process
from .adapters import Adapter, find
from .compare import BAD
from .filters import selector
from .ledger import Ledger
from .ledger import load as load_ledger
from .reports.words import where
from .results import Report, Result
from .running.case import Case, run_case


class Vectors:
    """The part of the plugin that works where adapters are given. Rules: CNF-15."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        given = [Path(word) for word in config.getoption("--snhc-adapter")]
        base = config.invocation_params.dir
        self._asked = [Path(os.path.normpath(base / path)) for path in given]
        self._configured = [Path(os.path.normpath(path)) for path in config.getini("snhc_adapters")]
        self._outcomes: dict[str, int] = {}
        self.adapters: list[Adapter] = []
        for path in self._asked:
            if not path.is_file():
                raise pytest.UsageError(f"--snhc-adapter: there is no file {path}")
        for line in (
            "snhc: a vector of the conformance suite of MPEG-4 face and mesh decoders",
            *(f"snhc_{tier}: a vector of the tier {tier}" for tier in TIERS),
        ):
            config.addinivalue_line("markers", line)
        # Configured files are run like those in testpaths: where no path is named.
        extra = list(self._asked)
        if config.args_source is not pytest.Config.ArgsSource.ARGS:
            extra += self._configured
        for path in extra:
            # Workers of pytest-xdist have got them already.
            if not any(Path(os.path.normpath(base / arg.partition("::")[0])) == path for arg in config.args):
                config.args.append(str(path))

    @cached_property
    def suite(self) -> Path:
        """The folder of the suite. Rules: CNF-3."""
        given = self._config.getoption("--snhc-suite")
        return SUITE if given is None else (self._config.invocation_params.dir / given).absolute()

    @cached_property
    def manifest(self) -> Manifest:
        """The suite. Rules: CNF-3."""
        return load(self.suite, check_schema=self.suite != SUITE)

    @cached_property
    def select(self) -> Callable[[Entry], bool]:
        """Which vectors are run. Rules: CNF-15."""
        return selector(self._config.getoption("--snhc-filter") or self._config.getini("snhc_filter"))

    @cached_property
    def ledger(self) -> Ledger | None:
        """The known failures. Rules: CNF-15."""
        given = self._config.getoption("--snhc-ledger")
        if given is not None:
            return load_ledger(self._config.invocation_params.dir / given)
        name = self._config.getini("snhc_ledger")
        return load_ledger(self._config.rootpath / name) if name else None

    def pytest_collect_file(self, file_path: Path, parent: pytest.Collector) -> pytest.Collector | None:
        """An adapter file is a file of tests. Rules: CNF-15."""
        if file_path not in (*self._asked, *self._configured):
            return None
        found: pytest.Collector = AdapterFile.from_parent(parent, path=file_path)
        return found

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Count what came of the vectors. Rules: CNF-15."""
        if "snhc" in report.keywords and (report.when == "call" or report.skipped):
            self._outcomes[report.outcome] = self._outcomes.get(report.outcome, 0) + 1

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """End the decoders; a run without any pass is a failure. Rules: CNF-15."""
        for adapter in self.adapters:
            adapter.close()
        process.close()
        if self._nothing_passed and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    @property
    def _nothing_passed(self) -> bool:
        return bool(self._outcomes) and not self._outcomes.get("passed")

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say why a run failed that shows no failure. Rules: CNF-15."""
        if self._nothing_passed and not self._outcomes.get("failed"):
            terminalreporter.write_line("snhc: no vector passed: that is no conformance", red=True)


class AdapterFile(pytest.File):
    """An adapter file: the vectors are its tests. Rules: CNF-13, CNF-15."""

    def collect(self) -> Iterator[pytest.Item]:
        """One test per selected vector."""
        plugin: Any = self.config.pluginmanager.get_plugin("snhc-vectors")
        try:
            adapter = find(str(self.path))
            entries = [entry for entry in plugin.manifest.entries if plugin.select(entry)]
            ledger = plugin.ledger
        except (SnhcError, OSError) as error:
            raise self.CollectError(f"snhc: {error}") from error
        if not entries:
            raise self.CollectError("snhc: the filter selects no vector: an empty run fails")
        plugin.adapters.append(adapter)
        for entry in entries:
            yield VectorItem.from_parent(
                self, name=entry.id, case=Case(adapter, entry), suite=plugin.suite, ledger=ledger
            )


class Failed(Exception):
    """A vector that does not pass. Rules: CNF-15."""


class VectorItem(pytest.Item):
    """One vector with one decoder. Rules: CNF-15, CNF-17."""

    def __init__(self, *, case: Case, suite: Path, ledger: Ledger | None, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._case = case
        self._suite = suite
        self._ledger = ledger
        self.add_marker(pytest.mark.snhc)
        self.add_marker(getattr(pytest.mark, f"snhc_{case.entry.tier}"))
        self.extra_keyword_matches.update((*case.entry.rules, case.entry.kind, *case.entry.tools))

    def runtest(self) -> None:
        """Ask the decoder, and say what came of it."""
        entry = self._case.entry
        result = run_case(self._case, self._suite)
        if self._ledger is not None:
            report = Report("", "", (result.adapter,), (result,))
            result = self._ledger.apply(report, [entry.id], date.today()).results[0]
        if result.status == "not_applicable":
            pytest.skip(result.reason)
        if result.status == "xfail":
            pytest.xfail(result.reason)
        if result.status in BAD:
            raise Failed(_words(result))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """What is wrong, without a traceback of ours."""
        if isinstance(excinfo.value, Failed):
            return str(excinfo.value)
        return super().repr_failure(excinfo)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Where the test stands, and its name."""
        return self.path, None, self.name


def _words(result: Result) -> str:
    lines = [f"{result.status}: {one_line(result.reason)}", f"title: {result.title}"]
    place = where(result)
    if place:
        lines.append(f"where: {place}")
    return "\n".join([*lines, f"rules: {', '.join(result.rules)}", f"again: {result.reproduce}"])
