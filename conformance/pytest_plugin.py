"""A pytest plugin: the vectors of the suite as tests of one's own decoder.

Rules: CNF-13, CNF-15, CNF-17.

    pytest --snhc-adapter my-decoder.toml            # or in the configuration: snhc_adapters = ["my-decoder.toml"]
    pytest my-decoder.toml::fap.arith.range.full

It is loaded with every pytest of an environment that has this package: what is not asked for is neither imported nor
done. The tests themselves are in `pytest_vectors`.
"""

from __future__ import annotations

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options and settings. Rules: CNF-15."""
    group = parser.getgroup("snhc", "conformance of MPEG-4 face and mesh decoders (snhc)")
    group.addoption(
        "--snhc-adapter", action="append", default=[], metavar="FILE",
        help="adapter file of a decoder: every vector of the suite becomes a test (repeatable)",
    )  # fmt: skip
    group.addoption("--snhc-filter", metavar="EXPR", help="vectors to run, as of `snhc run --filter`")
    group.addoption("--snhc-suite", metavar="DIR", help="folder of the suite, if not the one of the installation")
    group.addoption("--snhc-ledger", metavar="FILE", help="known failures, as of `snhc run --ledger`")
    parser.addini("snhc_adapters", "adapter files, relative to the configuration file", type="paths", default=[])
    parser.addini("snhc_filter", "vectors to run, as of `snhc run --filter`", default="")
    parser.addini("snhc_ledger", "known failures, as of `snhc run --ledger`", default="")


def pytest_configure(config: pytest.Config) -> None:
    """Register the tests, if there are any. Rules: CNF-15."""
    given = config.getoption("--snhc-adapter")
    if not given and not config.getini("snhc_adapters"):
        return
    from .pytest_vectors import Vectors

    config.pluginmanager.register(Vectors(config), "snhc-vectors")
