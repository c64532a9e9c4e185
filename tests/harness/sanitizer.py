"""A memory error that a sanitizer has found; it ends with 1."""

import sys

sys.stderr.write("==4242==ERROR: AddressSanitizer: heap-buffer-overflow on address 0x602000000011\n")
sys.exit(1)
