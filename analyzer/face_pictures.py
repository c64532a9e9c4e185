"""Picture files of a moving head: PNG (one frame or a sheet of frames), GIF with the stream's timing.

Rules: CNF-19, FBA-38.
Not here: GLB (`glb`).

A GIF counts hundredths of a second. The start of every frame is rounded, not its length, so that errors do not add
up; frames that come sooner than viewers can show them (20 ms) are left out.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from snhc.reference_impl.bitstream.errors import EncodeError

from .face_render import Picture

if TYPE_CHECKING:
    from PIL import Image

# Hundredths of a second: the shortest frame that viewers show as such, the last frame of a single picture, the longest.
SHORTEST: Final = 2
USUAL: Final = 4
LONGEST: Final = 65_535
_COLOURS: Final = 255
_LABEL: Final = (20, 24, 28)
_INSET: Final = (4, 2)
_BAND: Final = 16


def gif_plan(times: Sequence[Fraction]) -> list[tuple[int, int]]:
    """Which frames a GIF shows, and for how many hundredths of a second: (index, duration).

    Rules: FBA-38. `times`: seconds, one per frame. Where the clock goes back a frame lasts as long as the one
    before it; so does the last frame.
    """
    starts: list[tuple[int, int]] = []
    shift = Fraction(0)
    gap = Fraction(USUAL, 100)
    for index, time in enumerate(times):
        if index:
            step = time - times[index - 1]
            if step > 0:
                gap = step
            else:
                shift += gap - step
        start = int((time + shift) * 100 + Fraction(1, 2))
        if not starts or start - starts[-1][1] >= SHORTEST:
            starts.append((index, start))
    out = [(n, min(b - a, LONGEST)) for (n, a), (_, b) in pairwise(starts)]
    if starts:
        out.append((starts[-1][0], out[-1][1] if out else USUAL))
    return out


def spread(count: int, most: int) -> list[int]:
    """At most `most` of `count` numbers, evenly spread, the first and the last among them. Rules: CNF-19."""
    if count <= most:
        return list(range(count))
    if most == 1:
        return [0]
    return [(n * (count - 1) + (most - 1) // 2) // (most - 1) for n in range(most)]


def png(picture: Picture, colours: int | None = None) -> bytes:
    """A PNG file; with `colours`, of a palette of so many. Rules: CNF-19."""
    from PIL import Image

    image = _image(picture)
    if colours is not None:
        image = image.quantize(palette=_palette(image, colours), dither=Image.Dither.NONE)
    file = io.BytesIO()
    image.save(file, "PNG", optimize=True)
    return file.getvalue()


def sheet(pictures: Iterable[Picture], labels: Sequence[str], columns: int) -> Picture:
    """Pictures of one size side by side, each below its label. Rules: CNF-19. `columns`: at most."""
    from PIL import Image, ImageDraw

    drawn = []
    for picture, label in zip(pictures, labels, strict=True):
        image = Image.new("RGB", (picture.shape[1], picture.shape[0] + _BAND), "white")
        image.paste(_image(picture), (0, _BAND))
        ImageDraw.Draw(image).text(_INSET, label, fill=_LABEL)
        drawn.append(image)
    columns = max(1, min(columns, len(drawn)))
    width, height = drawn[0].size
    whole = Image.new("RGB", (width * columns, height * -(-len(drawn) // columns)), "white")
    for n, image in enumerate(drawn):
        whole.paste(image, (n % columns * width, n // columns * height))
    return np.asarray(whole)


def gif(
    pictures: Iterable[Picture],
    durations: Sequence[int],
    samples: Sequence[Picture],
    on_progress: Callable[[int], None] | None = None,
) -> bytes:
    """An animated GIF that repeats for ever.

    Rules: CNF-19, FBA-38. `durations`: hundredths of a second. `samples`: some of the pictures, which the palette is
    made from. Pictures are taken one at a time. Raises EncodeError where there are none.
    """
    if not durations or not samples:
        raise EncodeError("CNF-19", "frames", value=0, allowed="1 or more")
    palette = _palette(_image(np.concatenate(list(samples), axis=0)), _COLOURS)

    from PIL import Image

    def images() -> Iterator[Image.Image]:
        for done, picture in enumerate(pictures, 1):
            yield _image(picture).quantize(palette=palette, dither=Image.Dither.NONE)
            if on_progress is not None:
                on_progress(done)

    each = images()
    first = next(each)
    file = io.BytesIO()
    first.save(
        file, "GIF", save_all=True, append_images=each, duration=[10 * d for d in durations], loop=0, optimize=False
    )
    return file.getvalue()


def _palette(image: Image.Image, colours: int) -> Image.Image:
    """An image that holds a palette: most of it from the most frequent colours, a quarter from the rest.

    The usual median cut alone would give the eyes the colour of the skin.
    """
    from PIL import Image

    rare = colours // 4
    entries: list[int] = []
    for method, count in ((Image.Quantize.MEDIANCUT, colours - rare), (Image.Quantize.MAXCOVERAGE, rare)):
        found = image.quantize(count, method, dither=Image.Dither.NONE).getpalette()
        entries += (found or [])[: 3 * count]
    holder = Image.new("P", (1, 1))
    holder.putpalette(entries)
    return holder


def _image(picture: Picture) -> Image.Image:
    from PIL import Image

    return Image.fromarray(np.ascontiguousarray(picture))
