"""Sphinx configuration."""

import sys
from importlib.metadata import version as _version
from pathlib import Path

_HERE = Path(__file__).parent
sys.path.insert(0, str(_HERE))

from mutant_pages import write_kill_matrix  # noqa: E402
from register_pages import write_pages  # noqa: E402 (beside this file, which Sphinx does not import as a module)

project = "snhc"
author = "the snhc authors"
release = version = _version("snhc")
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "snhc"
exclude_patterns = ["_build"]
myst_heading_anchors = 3
myst_enable_extensions = ["deflist"]

write_pages(_HERE / "generated")

write_kill_matrix(_HERE / "generated")
