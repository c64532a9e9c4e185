"""Right, but writes into the file that it reads."""

import sys
from pathlib import Path

from _shared import answer, finish

Path(sys.argv[1]).write_bytes(b"overwritten")
finish(*answer())
