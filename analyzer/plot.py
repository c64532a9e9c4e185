"""Plots of a stream: FAP curves per group, bit rate over time, bits per plane.

Rules: SYS-11, FBA-38, CNF-19.

Drawn without a window; the same stream gives the same file.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

from snhc.reference_impl.bitstream.errors import EncodeError
from snhc.reference_impl.face.frames import FaceFrame
from snhc.reference_impl.tables import fap_groups, fap_table

from .stats import PARTS, StreamStats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PolyCollection

FORMATS: Final = ("png", "svg")
_WIDTH: Final = 11.0
_HEIGHT: Final = 2.1
_HIGH: Final = {
    1: ("viseme", ("select1", "select2", "blend")),
    2: ("expression", ("1", "intensity1", "2", "intensity2")),
}


def plot(stats: StreamStats, format: str = "png") -> bytes:
    """The plot as a file of one of FORMATS.

    Rules: SYS-11, CNF-19. `stats`: with `curves` kept. Raises EncodeError without planes.
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    if not stats.curves.times:
        raise EncodeError("CNF-19", "planes", value=0, allowed="1 or more")
    groups = _curves(stats.curves.frames)
    count = len(groups) + 2
    # The salt makes the ids in an SVG the same every time.
    with mpl.rc_context({"svg.hashsalt": "snhc", "font.size": 8, "axes.grid": True, "grid.alpha": 0.3}):
        figure = Figure(figsize=(_WIDTH, _HEIGHT * count), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        times = [float(_time(frame)) for frame in stats.curves.frames]
        for ax, (name, curves) in zip(axes, groups, strict=False):
            _group(ax, name, times, curves)
        _rate(axes[-2], stats)
        _planes(axes[-1], stats)
        axes[-1].set_xlabel("time [s]")
        file = io.BytesIO()
        metadata: dict[str, Any] = {"Date": None} if format == "svg" else {"Software": None}
        figure.savefig(file, format=format, dpi=100, metadata=metadata)
    return file.getvalue()


def _time(frame: FaceFrame) -> float:
    return frame.time[0] / frame.time[1]


def _curves(frames: Sequence[FaceFrame]) -> list[tuple[str, list[tuple[str, list[float]]]]]:
    """Per group that is used its name and curves: (label, values), nan where there is none."""
    nan = float("nan")
    out = []
    for group in fap_groups():
        curves: list[tuple[str, list[float]]] = []
        for fap in range(group.first_fap, group.last_fap + 1):
            if fap in _HIGH:
                attribute, names = _HIGH[fap]
                if any(getattr(frame, attribute) is not None for frame in frames):
                    for place, name in enumerate(names):
                        held = (getattr(frame, attribute) for frame in frames)
                        curves.append((f"{attribute} {name}", [nan if v is None else float(v[place]) for v in held]))
            elif any(frame.faps[fap - 1] is not None for frame in frames):
                column = (frame.faps[fap - 1] for frame in frames)
                curves.append((f"{fap} {fap_table()[fap - 1].name}", [nan if v is None else float(v) for v in column]))
        if curves:
            out.append((f"{group.group} {group.name}", curves))
    return out


def _group(ax: Axes, name: str, times: Sequence[float], curves: Sequence[tuple[str, Sequence[float]]]) -> None:
    from matplotlib import colormaps

    palette = colormaps["tab20"]
    for n, (label, values) in enumerate(curves):
        style = "-" if n < 20 else "--"
        marker = "." if len(times) < 3 else ""
        ax.plot(times, values, style, marker=marker, color=palette(n % 20), linewidth=1.0, label=label)
    ax.set_title(f"group {name}", loc="left")
    ax.set_ylabel("FAP units")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=6, ncols=1 + (len(curves) > 12))


def _rate(ax: Axes, stats: StreamStats) -> None:
    times = sorted(zip(stats.curves.times, stats.curves.bits, strict=True))
    sums = []
    total = last = 0
    for time, bits in times:
        while last < len(times) and times[last][0] < time + 1:
            total += times[last][1]
            last += 1
        sums.append(total / 1000)
        total -= bits
    ax.step([float(time) for time, _ in times], sums, where="post", color="C0")
    ax.axhline(float(stats.mean_rate) / 1000, color="C3", linewidth=0.8, label="mean")
    ax.set_title("bit rate: planes in [t, t + 1 s)", loc="left")
    ax.set_ylabel("kbit/s")
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper right", fontsize=6)


def _planes(ax: Axes, stats: StreamStats) -> None:
    width = 0.8 * float(stats.period)
    curves = stats.curves
    for flag, colour, label in ((False, "C0", "predicted"), (True, "C1", "intra")):
        chosen = [n for n, intra in enumerate(curves.intra) if intra is flag]
        if chosen:
            ax.add_collection(_bars([(float(curves.times[n]), curves.bits[n]) for n in chosen], width, colour, label))
    ax.autoscale_view()
    ax.set_ylim(bottom=0)
    largest = sorted(stats.parts, key=lambda part: -stats.parts[part])[:4]
    shares = ", ".join(f"{p} {100 * stats.parts[p] / max(stats.total_bits, 1):.0f} %" for p in PARTS if p in largest)
    ax.set_title(f"bits per plane ({shares})", loc="left")
    ax.set_ylabel("bits")
    ax.legend(loc="upper right", fontsize=6)


def _bars(tops: Sequence[tuple[float, int]], width: float, colour: str, label: str) -> PolyCollection:
    """Bars as one thing to draw: an hour of speech has 90,000 of them."""
    from matplotlib.collections import PolyCollection

    half = width / 2
    corners = [((x - half, 0), (x - half, y), (x + half, y), (x + half, 0)) for x, y in tops]
    return PolyCollection(corners, facecolors=colour, label=label)
