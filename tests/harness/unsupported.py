"""Says Unsupported to everything."""

import sys

sys.stderr.write('{"class":"Unsupported"}\n')
sys.exit(1)
