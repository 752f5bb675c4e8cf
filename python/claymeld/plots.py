"""Plots of recordings with matplotlib, for papers that want axes; `meldsim shot` takes the pictures."""

from __future__ import annotations

from typing import Any, Optional, Protocol, Sequence

import numpy
import pandas
from numpy.typing import NDArray

from .tool.packages import needed_for

GREY = (0.69, 0.69, 0.69, 1.0)
# Kinds of values that a legend still tells apart.
MOST_KINDS = 20
ROOT = 2**0.5
# What is whole numbers once it is multiplied by this, and the steps to all neighbours there: a catom that has all of them is not seen.
SPACES: dict[str, tuple[NDArray[numpy.float64], list[tuple[int, int, int]]]] = {
    "cubic": (numpy.ones(3), [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]),
    # Within a layer whole steps; half ones to the layers above and below, which are the root of a half away.
    "fcc": (numpy.array([2.0, 2.0, ROOT]), [(2, 0, 0), (-2, 0, 0), (0, 2, 0), (0, -2, 0)]
            + [(x, y, z) for x in (1, -1) for y in (1, -1) for z in (1, -1)]),
}
# The corners of a catom of diameter 1 in the plane.
CORNERS = {"square": (4, 1 / ROOT, numpy.pi / 4), "hex": (6, 1 / 3**0.5, numpy.pi / 6)}
ROUND = (24, 0.5, 0.0)


class Plotted(Protocol):
    """What plots ask of a recording. Recordings plot themselves, so their class is above this module, and not imported here."""

    ticks: NDArray[numpy.int64]
    lattice: str

    def step_of(self, tick: Optional[int] = None, method: Optional[str] = None) -> int: ...

    def frame(self, tick: Optional[int] = None) -> pandas.DataFrame: ...

    def metrics(self) -> pandas.DataFrame: ...

    def query(self, body: str, tick: Optional[int] = None) -> pandas.DataFrame: ...


def plot(recording: Plotted, tick: Optional[int] = None, colour: Any = None, *, ax: Any = None, method: Optional[str] = None,
         cmap: Any = "viridis", vmin: Optional[float] = None, vmax: Optional[float] = None, legend: bool = True, hidden: bool = False,
         size: float = 1.0, title: Optional[str] = None, **options: Any) -> Any:
    """A recorded tick in matplotlib's axes: in the plane each catom in its shape and size, in space a scatter.

    Parameters
    ----------
    tick, method
        Of a recorded tick; see `Recording`.
    colour : str, array, pandas.Series or None
        None: the colours of the catoms. A column of frame(), such as "dist". A body in Meld, "dist(A, D)": the last variable other than its
        first catom, or whether it holds. A Series is by the number of the catom; an array in the order of frame().
    ax : matplotlib.axes.Axes
        Where; of three dimensions for catoms in space. None: in a new figure.
    cmap, vmin, vmax
        Colours of numbers, and those at the ends.
    legend : bool
        A bar of colours, or of other values their list.
    hidden : bool
        In space on a lattice, also those catoms that others surround.
    size : float
        Of the catoms, 1: touching.
    **options
        To matplotlib's PolyCollection or scatter.

    Returns
    -------
    matplotlib.axes.Axes
    """
    with needed_for("plot()"):
        import matplotlib.pyplot

    step = recording.step_of(tick, method)
    tick = int(recording.ticks[step])
    frame = recording.frame(tick)
    places = frame[["x", "y", "z"]].to_numpy("float64")
    diameters = _thickness(frame)
    alike = "diameter" not in frame and "rounding" not in frame
    flat = recording.lattice in CORNERS or (len(places) > 0 and float(numpy.ptp(places[:, 2])) == 0.0 and alike)
    if ax is not None:
        flat = flat and getattr(ax, "name", "") != "3d"
    else:
        ax = matplotlib.pyplot.figure().add_subplot(projection=None if flat else "3d")
    colours, kinds, numbers, name = _colours(recording, frame, tick, colour, cmap, vmin, vmax)
    if flat:
        _draw_flat(ax, recording.lattice, places, diameters * size, colours, options)
        _draw_tails(ax, frame)
    else:
        seen = numpy.ones(len(places), bool) if hidden else exposed(places, recording.lattice)
        _draw_space(ax, places, seen, diameters * size, colours, options)
    if legend and numbers is not None:
        ax.figure.colorbar(numbers, ax=ax, label=name, shrink=0.8)
    if legend and kinds:
        from matplotlib.patches import Patch

        ax.legend(handles=[Patch(color=paint, label=str(kind)) for kind, paint in kinds.items()], title=name, loc="center left",
                  bbox_to_anchor=(1.02, 0.5))
    ax.set_title(f"tick {tick}" if title is None else title)
    return ax


def _thickness(frame: pandas.DataFrame) -> NDArray[numpy.float64]:
    """The diameters of catoms; of bodies that are no spheres, those of the balls that fit into them, and of compounds around them."""
    if "rounding" in frame:
        cores = frame[["core_x", "core_y", "core_z"]].to_numpy("float64")
        # A cylinder has its radius as x, and no y.
        cylinders = (cores[:, 0] > 0) & (cores[:, 1] == 0)
        cores[cylinders, 1] = cores[cylinders, 0]
        roundings = frame["rounding"].to_numpy("float64")
        # Of a compound, x is the radius of the ball around it, and the rounding no length.
        return numpy.asarray(2 * numpy.where(roundings < 0, cores[:, 0], cores.min(axis=1) + roundings))
    return numpy.asarray(frame["diameter"].to_numpy("float64") if "diameter" in frame else numpy.ones(len(frame)))


def exposed(places: NDArray[numpy.float64], lattice: str) -> NDArray[numpy.bool_]:
    """Which catoms on a lattice have a free place beside them; all, where the lattice has none in space. (catoms, 3) to (catoms,)."""
    if lattice not in SPACES or len(places) == 0:
        return numpy.ones(len(places), bool)
    scale, steps = SPACES[lattice]
    cells = numpy.rint((places - places.min(axis=0)) * scale).astype("int64") + 2
    extent = cells.max(axis=0) + 3
    keys = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    ordered = numpy.sort(keys)
    surrounded = numpy.ones(len(keys), bool)
    for x, y, z in steps:
        beside = keys + (x * extent[1] + y) * extent[2] + z
        found = numpy.minimum(numpy.searchsorted(ordered, beside), len(ordered) - 1)
        surrounded &= ordered[found] == beside
    return numpy.asarray(~surrounded)


def _colours(recording: Plotted, frame: pandas.DataFrame, tick: int, colour: Any, cmap: Any, vmin: Optional[float],
             vmax: Optional[float]) -> tuple[NDArray[numpy.float64], dict[Any, Any], Any, str]:
    """The colour of each catom, (catoms, 4); then of kinds of values, or a scale of numbers; and what they are called."""
    import matplotlib

    if colour is None:
        paint = numpy.ones((len(frame), 4))
        paint[:, :3] = frame[["red", "green", "blue"]].to_numpy() / 255.0
        return paint, {}, None, ""
    values, name = _values(recording, frame, tick, colour)
    colours = numpy.tile(numpy.array(GREY), (len(frame), 1))
    there = values.notna().to_numpy()
    if pandas.api.types.is_numeric_dtype(values) and not pandas.api.types.is_bool_dtype(values):
        if vmin is None and vmax is None:
            values, name = _near_zero(values, there, name)
        cells = values.to_numpy("float64", na_value=numpy.nan)
        there &= numpy.isfinite(cells)
        low = vmin if vmin is not None else (float(cells[there].min()) if there.any() else 0.0)
        high = vmax if vmax is not None else (float(cells[there].max()) if there.any() else 1.0)
        numbers = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(low, high), cmap)
        colours[there] = numbers.to_rgba(cells[there])
        return colours, {}, numbers, name
    texts = values[there].map(str)
    kinds = sorted(set(texts), key=lambda kind: (len(kind), kind))
    wheel = matplotlib.colormaps["tab10" if len(kinds) <= 10 else "tab20"]
    paints = {kind: wheel(number % wheel.N) for number, kind in enumerate(kinds)}
    if len(kinds):
        colours[there] = numpy.array([paints[text] for text in texts])
    return colours, paints if len(kinds) <= MOST_KINDS else {}, None, name


def _near_zero(values: pandas.Series, there: NDArray[numpy.bool_], name: str) -> tuple[pandas.Series, str]:
    """Whole numbers of more than 53 bits as what they have above the least of them, which is part of their name then: a float is exact
    up to there."""
    if not pandas.api.types.is_integer_dtype(values) or not there.any():
        return values, name
    whole = [int(value) for value in values[there]]
    least = min(whole)
    if max(-least, max(whole)) <= 2**53:
        return values, name
    above = pandas.Series(numpy.nan, index=values.index, dtype="float64")
    above[there] = [float(value - least) for value in whole]
    return above, f"{name} - {least}"


def _values(recording: Plotted, frame: pandas.DataFrame, tick: int, colour: Any) -> tuple[pandas.Series, str]:
    """A value for each row of the frame, missing where there is none."""
    if not isinstance(colour, str):
        if isinstance(colour, pandas.Series):
            return colour.reindex(frame["catom"]).reset_index(drop=True), str(colour.name or "")
        if len(colour) != len(frame):
            raise ValueError(f"colour has {len(colour)} values, and there are {len(frame)} catoms in tick {tick}")
        return pandas.Series(numpy.asarray(colour)), ""
    if colour in frame:
        return frame[colour], colour
    if "(" not in colour:
        raise KeyError(f"there is no column '{colour}' in the frame of tick {tick}; there are {', '.join(frame.columns)}. "
                       f"A body in Meld, as \"{colour}(A, X)\", asks the run")
    found = recording.query(colour, tick)
    catom = next((name for name, kind in found.attrs["types"].items() if kind == "node"), None)
    if catom is None:
        raise ValueError(f"no variable is a catom in {colour!r}")
    others = [name for name in found.columns if name != catom]
    # Of several values at a catom one is shown, the first.
    rows = found.drop_duplicates(catom).set_index(catom)
    values = rows[others[-1]] if others else pandas.Series(True, index=rows.index).map({True: colour})
    return values.reindex(frame["catom"]).reset_index(drop=True), others[-1] if others else ""


def _draw_tails(ax: Any, frame: pandas.DataFrame) -> None:
    """A bar from the head to the tail of each amoebot with two cells."""
    from matplotlib.collections import LineCollection

    if "tail_x" not in frame:
        return
    ends = frame[["x", "y", "tail_x", "tail_y"]].to_numpy("float64").reshape(-1, 2, 2)
    ends = ends[numpy.abs(ends[:, 1] - ends[:, 0]).max(axis=1) > 0.5]
    ax.add_collection(LineCollection(ends, colors="#3c3c3c", linewidths=2.5, capstyle="round"))


def _draw_flat(ax: Any, lattice: str, places: NDArray[numpy.float64], sizes: NDArray[numpy.float64], colours: NDArray[numpy.float64],
               options: dict[str, Any]) -> None:
    from matplotlib.collections import PolyCollection

    count, radius, turn = CORNERS.get("square" if lattice == "cubic" else lattice, ROUND)
    angles = turn + numpy.arange(count) * 2 * numpy.pi / count
    shape = radius * numpy.stack([numpy.cos(angles), numpy.sin(angles)], axis=1)
    corners = places[:, None, :2] + sizes[:, None, None] * shape[None]
    ax.add_collection(PolyCollection(corners, facecolors=colours, **{"edgecolors": "white", "linewidths": 0.3, **options}))
    ax.set_aspect("equal")
    ax.autoscale_view()


def _draw_space(ax: Any, places: NDArray[numpy.float64], seen: NDArray[numpy.bool_], sizes: NDArray[numpy.float64],
                colours: NDArray[numpy.float64], options: dict[str, Any]) -> None:
    low, high = (places.min(axis=0) - 0.5, places.max(axis=0) + 0.5) if len(places) else (numpy.zeros(3), numpy.ones(3))
    for axis, name in enumerate("xyz"):
        getattr(ax, f"set_{name}lim")(low[axis], high[axis])
    ax.set_box_aspect(high - low)
    box = ax.get_window_extent()
    # Points on the page for a diameter: the diagonal of the ensemble fills about the smaller side of the axes.
    points = 0.75 * min(box.width, box.height) * 72 / ax.figure.dpi / float(numpy.linalg.norm(high - low)) * 1.3
    shown = places[seen]
    ax.scatter(shown[:, 0], shown[:, 1], shown[:, 2], c=colours[seen],
               **{"s": (points * sizes[seen]) ** 2, "linewidths": 0.2 if points > 6 else 0.0, "edgecolors": "white",
                  "depthshade": False, **options})


def plot_metrics(recording: Plotted, columns: Optional[Sequence[str]] = None, ax: Any = None, **options: Any) -> Any:
    """Columns of metrics() over the ticks (None: all that change), in matplotlib's axes, which are returned; `options` go to
    pandas.DataFrame.plot."""
    with needed_for("plot_metrics()"):
        import matplotlib  # noqa: F401  pandas plots with it, and says less of it.

    metrics = recording.metrics().drop(columns="digest")
    if columns is None:
        columns = [name for name in metrics if metrics[name].nunique() > 1] or ["catoms"]
    axes = metrics[list(columns)].plot(ax=ax, **options)
    return axes
