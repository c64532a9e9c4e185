"""An exit code that means nothing."""

import sys

sys.exit("usage error, or what not" and 2)
