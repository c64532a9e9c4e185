"""The clean-room codec: every syntax table once, read, written, traced and broken on purpose.

Imports nothing from `snhc.analyzer`, `snhc.vectors` or `snhc.conformance`.
"""

from . import _forms as _forms
