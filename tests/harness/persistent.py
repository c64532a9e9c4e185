"""A persistent decoder made of a one-shot one, or one that breaks the protocol: `persistent.py NAME [WORDS...]`.

NAME: a script of this folder (run in this process for every vector), or one of the faults below. The first question is
number 1; faults come with the first vector.
"""

from __future__ import annotations

import io
import json
import os
import runpy
import sys
import time
from pathlib import Path
from typing import Any

from _shared import answer

Message = dict[str, Any]
TO_RUNNER = os.fdopen(os.dup(1), "w", encoding="utf-8", newline="\n")


def say(message: Message) -> None:
    TO_RUNNER.write(json.dumps(message) + "\n")
    TO_RUNNER.flush()


def raw(text: str) -> None:
    TO_RUNNER.write(text)
    TO_RUNNER.flush()


def as_one_shot(name: str, words: list[str], path: str) -> Message:
    """Run a script of the bank as if it were started for this vector."""
    out, err = io.TextIOWrapper(io.BytesIO(), encoding="utf-8"), io.StringIO()
    before = sys.argv, sys.stdout, sys.stderr
    sys.argv, sys.stdout, sys.stderr = [name, path, *words], out, err
    code: object = 0
    try:
        runpy.run_path(str(Path(__file__).with_name(f"{name}.py")), run_name="__main__")
    except SystemExit as exit:
        code = exit.code
        if isinstance(code, str):
            err.write(code)
            code = 1
    finally:
        sys.argv, sys.stdout, sys.stderr = before
    out.flush()
    output = out.buffer.getvalue().decode("utf-8", "surrogateescape")
    if code in (0, None):
        return {"status": "accepted", "output": output}
    if code != 1:
        os._exit(int(str(code)))
    lines = [line for line in err.getvalue().splitlines() if line.startswith("{")]
    return {"status": "rejected", "error": json.loads(lines[-1]) if lines else {}, "output": output}


def right(message: Message) -> Message:
    lines, said, code = answer(message["input"])
    status: Message = {"status": "accepted", "output": "".join(lines)}
    if code:
        status = {"status": "rejected", "error": json.loads(said)}
    return {"seq": message["seq"], "type": "decode", **status}


def fault(name: str, message: Message) -> None:
    good = right(message)
    if name == "wrong_seq":
        say({**good, "seq": good["seq"] + 1})
    elif name == "seq_of_the_last":
        say({**good, "seq": good["seq"] - 1})
    elif name == "seq_is_text":
        say({**good, "seq": str(good["seq"])})
    elif name == "seq_is_float":
        say({**good, "seq": float(good["seq"])})
    elif name == "wrong_type":
        say({**good, "type": "hello"})
    elif name == "two_answers":
        say(good)
        say(good)
    elif name == "second_answer_later":
        say(good)
        time.sleep(0.05)
        say(good)
    elif name == "no_answer":
        pass
    elif name == "garbage_before":
        raw("decoding...\n")
        say(good)
    elif name == "garbage_behind":
        say(good)
        raw("done\n")
    elif name == "half_a_line_behind":
        raw(json.dumps(good) + "\n{")
    elif name == "no_line_end":
        raw(json.dumps(good))
    elif name == "dies_in_the_message":
        raw(json.dumps(good)[:40])
        os._exit(3)
    elif name == "dies_by_signal":
        os.abort()
    elif name == "dies_behind_its_answer":
        say(good)
        os.abort()
    elif name == "leaves_without_a_word":
        os._exit(0)
    elif name == "closes_stdin":
        os.close(0)
        say(good)
        time.sleep(60)
    elif name == "closes_stdout":
        TO_RUNNER.close()
        os.close(1)
        time.sleep(60)
    elif name == "not_an_object":
        say([good])  # type: ignore[arg-type]
    elif name == "no_status":
        say({"seq": good["seq"], "type": "decode", "output": ""})
    elif name == "unknown_status":
        say({**good, "status": "ok"})
    elif name == "accepted_without_output":
        say({"seq": good["seq"], "type": "decode", "status": "accepted"})
    elif name == "lines_for_output":
        say({**good, "output": str(good.get("output", "")).splitlines()})
    elif name == "floods_a_line":
        while True:
            raw("x" * 65536)
    elif name == "floods_lines":
        while True:
            raw("\n" * 65536)
    elif name == "floods_stderr":
        sys.stderr.write("y" * (4 << 20))
        say(good)
    elif name == "says_crash":
        say({"seq": good["seq"], "type": "decode", "status": "crash", "detail": "own words"})
    elif name == "half_a_surrogate":
        say({**good, "output": "\ud800"})
    elif name == "bits_as_text":
        say({"seq": good["seq"], "type": "decode", "status": "rejected", "error": {"bits": "0-8"}})
    elif name == "changes_hello":
        say(good)
    else:
        raise LookupError(name)


HELLO: dict[str, Message] = {
    "wrong_version": {"version": 2},
    "wrong_protocol": {"protocol": "another"},
    "unknown_tool": {"tools": ["fba", "speech"]},
    "claims_nothing": {"tools": []},
    "claims_fap_only": {"formats": ["fap"]},
    "claims_no_faults": {"kinds": ["valid"]},
    "correct_with_options": {"options": ["draft", "strict", "object", "limit"]},
}
CORRECT = ("correct_with_options", "correct_no_bye", "lingers_after_bye", "talks_after_bye", "exits_7_after_bye")


def main(name: str, words: list[str]) -> None:
    first = True
    for line in sys.stdin:
        message = json.loads(line)
        kind = message["type"]
        if kind == "hello":
            if name == "never_answers_hello":
                continue
            if name == "dies_at_hello":
                sys.exit("no licence found")
            greeting = {"protocol": "snhc-adapter", "version": 1, **HELLO.get(name, {})}
            if name == "changes_hello" and not first:
                greeting["version"] = 3
            say({"seq": message["seq"], "type": "hello", **greeting})
        elif kind == "decode":
            if Path(__file__).with_name(f"{name}.py").exists():
                say({"seq": message["seq"], "type": "decode", **as_one_shot(name, words, message["input"])})
            elif not first or name in HELLO or name in CORRECT:
                say(right(message))
            else:
                fault(name, message)
            first = False
        else:
            if name == "correct_no_bye":
                sys.exit(0)
            say({"seq": message["seq"], "type": "bye"})
            if name == "talks_after_bye":
                raw("so long\n")
            if name == "lingers_after_bye":
                time.sleep(60)
            sys.exit(7 if name == "exits_7_after_bye" else 0)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
