"""Exit 1 on everything."""

import sys

sys.exit(1)
