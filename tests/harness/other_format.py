"""Right, in the format that is asked for."""

import sys
from pathlib import Path

from snhc.reference_impl.systems.output import frame_writer
from snhc.reference_impl.systems.stream import decode_planes

writer = frame_writer(sys.argv[2], sys.stdout.buffer.write)
writer.begin("fba")
for plane in decode_planes(Path(sys.argv[1]).read_bytes()):
    writer.plane(plane)
writer.end()
writer.close()
