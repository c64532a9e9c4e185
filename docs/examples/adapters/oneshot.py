"""oneshot.py INPUT: a decoder in Python, one start per vector."""
import json
import sys

import mydecoder

try:
    with open(sys.argv[1], "rb") as file:
        print('{"format":"snhc-decoded","version":1,"kind":"fba"}')
        for index, plane in enumerate(mydecoder.planes(file.read())):
            print(json.dumps({
                "index": index, "time": f"{plane.time.numerator}/{plane.time.denominator}", "intra": plane.intra,
                "faps": plane.faps, "viseme": plane.viseme, "expression": plane.expression, "state": plane.state,
            }))
except mydecoder.BadStream as error:
    print(json.dumps({"class": error.kind, "bits": [error.first, error.end]}), file=sys.stderr)
    sys.exit(1)
