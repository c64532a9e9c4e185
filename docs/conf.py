"""Sphinx configuration."""

from importlib.metadata import version as _version

project = "snhc"
author = "the snhc authors"
release = version = _version("snhc")
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "snhc"
exclude_patterns = ["_build"]
myst_heading_anchors = 3
