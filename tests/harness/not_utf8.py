"""Bytes that are no UTF-8."""

import sys

sys.stdout.buffer.write(b'{"format":"snhc-decoded","version":1,"kind":"fba"}\n\xff\xfe\n')
