"""`snhc dct`: quantised DCT coefficients to frames, without any entropy table.

Rules: CNF-1, CNF-19, CNF-24, CNF-25, DCT-3, DCT-5..7, DCT-13.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import click

from .common import Common, Output, common_options, open_binary

if TYPE_CHECKING:
    from snhc.reference_impl.face.dct_transform import Normalisation


@click.command()
@click.argument("coefficients")
@common_options()
def command(coefficients: str, common: Common) -> None:
    """Decode quantised DCT coefficients to frames.

    COEFFICIENTS: a JSON document (docs/formats-model.md), - for standard input. Readings: AMB-DCT-1, AMB-DCT-2.
    """
    from snhc.reference_impl.face.coefficients import decode_document, parse_document
    from snhc.reference_impl.face.dct_transform import DctReading
    from snhc.reference_impl.face.decoded import header_line

    readings = common.readings
    normalisation: Normalisation = "unnormalised" if readings.normalisation == "unnormalised" else "orthonormal"
    with Output(common.output, common.keep_partial) as out:
        with open_binary(coefficients) as stream:
            data = stream.read(common.limits.json_bytes + 1)
        document = parse_document(data, limit=common.limits.json_bytes)
        out.write(header_line("fba", readings) + "\n")
        for frame in decode_document(document, DctReading(readings.dc_step_ratio, normalisation)):
            out.write(json.dumps(frame.as_json(), separators=(",", ":")) + "\n")
