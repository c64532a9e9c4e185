"""Hands the extension modules that the build backend (packaging/snhc_build.py) has made to setuptools."""

import sys

from setuptools import setup

backend = sys.modules.get("snhc_build")
setup(ext_modules=list(backend.EXTENSIONS) if backend is not None else [])
