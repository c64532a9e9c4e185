"""Calls everything unsupported, but not in the JSON line."""

import sys

sys.exit("Unsupported")
