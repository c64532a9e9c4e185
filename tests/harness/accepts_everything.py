"""A header and exit 0 on everything."""

import sys

sys.stdout.write('{"format":"snhc-decoded","version":1,"kind":"fba"}\n')
