"""Right, on standard error."""

import sys

from _shared import answer

lines, _, code = answer()
sys.stderr.write("".join(lines))
sys.exit(code)
