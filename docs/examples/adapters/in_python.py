"""in_python.py: the same decoder as a callable, held by a process of snhc."""
import mydecoder
from snhc.conformance.decoders import Rejected


def decode(request):
    yield {"format": "snhc-decoded", "version": 1, "kind": "fba"}
    try:
        for index, plane in enumerate(mydecoder.planes(request.data)):
            time = f"{plane.time.numerator}/{plane.time.denominator}"
            yield {
                "index": index, "time": time, "intra": plane.intra, "faps": plane.faps,
                "viseme": plane.viseme, "expression": plane.expression, "state": plane.state,
            }
    except mydecoder.BadStream as error:
        raise Rejected(error.kind, (error.first, error.end)) from error


decode.capabilities = {"tools": ["fba"]}
