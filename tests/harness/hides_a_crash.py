"""A wrapper: the real decoder dies of a signal, and that becomes exit code 1, as a rejection."""

import subprocess
import sys

command = "ulimit -c 0; sh -c 'kill -SEGV $$' decoder; exit 1"
sys.exit(subprocess.run(["bash", "-c", command], check=False).returncode)
