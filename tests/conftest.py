"""What all tests share: the corpus option, and a summary line for whatever could not run.

Nothing skips silently: a test that cannot run here is counted in a line `not run: ...` at the end.
"""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from snhc.conformance.cli.version import form

PURE_ONLY = "replaces or measures the code of the decoder: pure form only"
NOT_BUILT = "the package was built without a compiled form"
CORPUS_MISSING = "no real files given (--corpus DIR or SNHC_CORPUS=DIR)"

# Generated streams are large records: their size is no sign of a bad strategy. Failures print how to replay them.
settings.register_profile(
    "snhc", deadline=None, print_blob=True, suppress_health_check=[HealthCheck.data_too_large, HealthCheck.too_slow]
)
settings.register_profile("snhc-deep", parent=settings.get_profile("snhc"), max_examples=2_000)
settings.load_profile(os.environ.get("SNHC_HYPOTHESIS_PROFILE", "snhc"))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--corpus", metavar="DIR", default=None, help="folder with real .fap files (or SNHC_CORPUS)")
    parser.addoption(
        "--form", choices=("pure", "compiled", "compiled-if-built"), default=None,
        help="the form of the codec that must run; compiled-if-built: without one, every test counts as not run",
    )  # fmt: skip


def pytest_report_header() -> str:
    return f"codec: {form()}"


def pytest_configure(config: pytest.Config) -> None:
    wanted = config.getoption("--form")
    if wanted in ("pure", "compiled") and wanted != form():
        raise pytest.UsageError(f"--form {wanted}, but the codec that runs is {form()} (SNHC_PURE, SNHC_COMPILE)")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    not_built = config.getoption("--form") == "compiled-if-built" and form() != "compiled"
    for item in items:
        if not_built:
            item.add_marker(pytest.mark.skip(reason=NOT_BUILT))
        elif form() == "compiled" and item.get_closest_marker("pure") is not None:
            item.add_marker(pytest.mark.skip(reason=PURE_ONLY))


@pytest.fixture
def corpus(request: pytest.FixtureRequest) -> Path:
    """The folder with real files from elsewhere; the test counts as not run where there is none."""
    given = request.config.getoption("--corpus") or os.environ.get("SNHC_CORPUS")
    if not given:
        pytest.skip(CORPUS_MISSING)
    folder = Path(given)
    # A folder that was named but is not there is a mistake, not a machine without a corpus.
    if not folder.is_dir():
        pytest.fail(f"the corpus folder {folder} does not exist", pytrace=False)
    return folder


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    reasons: Counter[str] = Counter()
    for report in terminalreporter.stats.get("skipped", []):
        reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
        reasons[reason.removeprefix("Skipped: ")] += 1
    for reason, count in sorted(reasons.items()):
        terminalreporter.write_line(f"not run: {count} {'test' if count == 1 else 'tests'}: {reason}")
