"""persistent.py: the same decoder, one process for all vectors."""
import json
import sys

import mydecoder


def decode(question):
    lines = ['{"format":"snhc-decoded","version":1,"kind":"fba"}']
    try:
        with open(question["input"], "rb") as file:
            for index, plane in enumerate(mydecoder.planes(file.read())):
                time = f"{plane.time.numerator}/{plane.time.denominator}"
                lines.append(json.dumps({
                    "index": index, "time": time, "intra": plane.intra, "faps": plane.faps,
                    "viseme": plane.viseme, "expression": plane.expression, "state": plane.state,
                }))
    except mydecoder.BadStream as error:
        said = {"class": error.kind, "bits": [error.first, error.end]}
        return {"status": "rejected", "error": said}
    return {"status": "accepted", "output": "\n".join(lines) + "\n"}


for line in sys.stdin:
    question = json.loads(line)
    answer = {"seq": question["seq"], "type": question["type"]}
    if question["type"] == "hello":
        answer |= {"protocol": "snhc-adapter", "version": 1, "tools": ["fba"]}
    elif question["type"] == "decode":
        answer |= decode(question)
    print(json.dumps(answer), flush=True)
    if question["type"] == "bye":
        break
