"""callable.py: the same decoder as a Python callable; snhc holds it in a process of its own."""
import mydecoder
from snhc.conformance.decoders import Rejected


def decode(request):
    yield {"format": "snhc-decoded", "version": 1, "kind": "fba"}
    try:
        for index, plane in enumerate(mydecoder.planes(request.data)):
            yield {
                "index": index, "time": f"{plane.time.numerator}/{plane.time.denominator}", "intra": plane.intra,
                "faps": plane.faps, "viseme": plane.viseme, "expression": plane.expression, "state": plane.state,
            }
    except mydecoder.BadStream as error:
        raise Rejected(error.kind, (error.first, error.end)) from error


decode.capabilities = {"tools": ["fba"]}
