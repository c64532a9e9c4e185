"""oneshot.py INPUT: a decoder in Python, one start per vector."""
import json
import sys

import mydecoder

try:
    with open(sys.argv[1], "rb") as file:
        print('{"format":"snhc-decoded","version":1,"kind":"fba"}')
        for index, plane in enumerate(mydecoder.planes(file.read())):
            time = f"{plane.time.numerator}/{plane.time.denominator}"
            print(json.dumps({
                "index": index, "time": time, "intra": plane.intra, "faps": plane.faps,
                "viseme": plane.viseme, "expression": plane.expression, "state": plane.state,
            }))
except mydecoder.BadStream as error:
    said = {"class": error.kind, "bits": [error.first, error.end]}
    print(json.dumps(said), file=sys.stderr)
    sys.exit(1)
