"""Recordings of runs, as pandas frames: claymeld.open()."""

from __future__ import annotations

import collections
import html
import os
import threading
import tomllib
from typing import Any, Iterator, Optional, Sequence, Union

import numpy
import pandas

from . import answers, pictures, plots
from .answers import Why
from .data import planned
from .data.layout import Steps
from .data.scratch import Scratch
from .data.tables import NUMBERS, facts as read_facts
from .data.values import value
from .live import Live
from .tool.calls import Path, call
from .tool.packages import needed_for

# A tick; or several: a slice of ticks, both ends included, a list of ticks, or "all" that are recorded.
Ticks = Union[int, slice, Sequence[int], str, None]
METHODS = ("nearest", "pad", "backfill")
# How many ticks are kept that were made again.
KEPT = 4
# Arrays of several numbers a catom, and the columns of a frame that they are: where the other cells of amoebots are; what bodies look like
# that are no spheres, and how they are turned.
PARTS = {"tail_position": ("tail_x", "tail_y", "tail_z"), "core": ("core_x", "core_y", "core_z", "rounding"),
         "orientation": ("orientation_w", "orientation_x", "orientation_y", "orientation_z"),
         "joint.orientation": ("orientation_w", "orientation_x", "orientation_y", "orientation_z")}
# Of joints, by the numbers in the file.
KINDS, FATES = ("hinge", "slider", "ball"), ("holds", "broken", "gone")


class Recording:
    """A recording; also one that is still being written, or whose run was killed: it has the steps that are whole when it is opened.

    Ticks are labels, as in `pandas.DataFrame.loc`: a number from 0 on is a tick, a negative one counts recorded steps from the end, and
    None is the last. Slices of ticks have both ends in them. A tick that is not recorded is a KeyError, unless `method` says which is
    taken instead: "pad" the last recorded one before, "backfill" the next after, "nearest" the nearer, and the earlier of two.

    What is asked of a recording and is not in it, such as facts of other predicates and ticks, is had by making the run again up to
    there: the recording carries all that this takes, and the result is the same bit for bit. It takes meldsim, and as long as the run.

        with claymeld.open("run.vtkhdf") as recording:
            recording.frame(-1)
            recording.facts("dist", 20)

    Attributes
    ----------
    path : str
    ticks : numpy.ndarray
        The recorded ticks, int64, (steps,).
    lattice : str
    seed : int
    radius : float
        Of a catom, in metres.
    """

    def __init__(self, path: Path, *, meldsim: Optional[Path] = None) -> None:
        self.path = os.fspath(path)
        self._meldsim = meldsim
        self._steps = Steps(path)
        self.ticks = self._steps.ticks
        self.lattice: str = self._steps.lattice
        self.seed: int = self._steps.seed
        self.radius: float = self._steps.radius
        self._scratch: Optional[Scratch] = None  # Where a temporary recording is.
        self._again: collections.OrderedDict[int, tuple[Scratch, str]] = collections.OrderedDict()
        self._lock = threading.Lock()

    def __enter__(self) -> Recording:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Closes the file; what has been read stays."""
        self._steps.close()

    def __reduce__(self) -> Any:
        return Recording, (self.path,)

    def __len__(self) -> int:
        return len(self.ticks)

    def __iter__(self) -> Iterator[tuple[int, pandas.DataFrame]]:
        """Of each step, the tick and the frame."""
        return self.frames()

    def __repr__(self) -> str:
        recorded = f", {', '.join(self.predicates)}" if self.predicates else ""
        if not len(self):
            return f"<Recording {self.path}: no steps{recorded}>"
        return (f"<Recording {self.path}: {len(self)} steps, ticks {self.ticks[0]} to {self.ticks[-1]}, "
                f"{self._steps.count(len(self) - 1):,} catoms{recorded}>")

    # ---- what it is of

    @property
    def predicates(self) -> list[str]:
        """The names of the recorded predicates."""
        return list(self._steps.predicates)

    @property
    def program(self) -> str:
        """The text of the program. `provenance["program"]` has the files that it includes too."""
        return self._steps.text("program")

    @property
    def world(self) -> dict[str, Any]:
        """The world, with the keys of its file."""
        return tomllib.loads(self._steps.text("world"))

    @property
    def provenance(self) -> dict[str, Any]:
        """What it takes to make the run again: version, program and world with their files, constants, seed."""
        found: dict[str, Any] = self._steps.json("provenance", {})
        return found

    @property
    def command(self) -> list[str]:
        """The command of the run."""
        return self._steps.words()

    # ---- ticks

    def step_of(self, tick: Optional[int] = None, method: Optional[str] = None) -> int:
        """The number of the step of a tick, from 0 on.

        Raises
        ------
        KeyError
            The tick is not recorded, or there is none that `method` may take.
        """
        if method is not None and method not in METHODS:
            raise ValueError(f"method is {method!r}; there are {', '.join(METHODS)} and None")
        if not len(self):
            raise KeyError(f"{self.path} has no steps")
        if tick is None:
            return len(self) - 1
        tick = int(tick)
        if tick < 0:
            if tick < -len(self):
                raise KeyError(f"there is no step {tick} in {self.path}; it has {len(self)}")
            return len(self) + tick
        after = int(numpy.searchsorted(self.ticks, tick))
        if after < len(self) and self.ticks[after] == tick:
            return after
        if method == "pad" and after > 0:
            return after - 1
        if method == "backfill" and after < len(self):
            return after
        if method == "nearest":
            if after == len(self) or (after > 0 and tick - self.ticks[after - 1] <= self.ticks[after] - tick):
                return after - 1
            return after
        near = " and ".join(str(self.ticks[n]) for n in (after - 1, after) if 0 <= n < len(self))
        raise KeyError(f"tick {tick} is not recorded; next to it are {near}. method='nearest' takes one of these; facts(), query(), "
                       "why() and shot() take any tick of the run")

    def steps_of(self, ticks: Ticks) -> list[int]:
        """The numbers of the steps of several ticks; those of a slice lie between its ends, and both ends belong to it."""
        if isinstance(ticks, slice):
            if not len(self):
                return []
            ends = [None if end is None else (int(self.ticks[self.step_of(end)]) if end < 0 else end) for end in (ticks.start, ticks.stop)]
            begin = 0 if ends[0] is None else int(numpy.searchsorted(self.ticks, ends[0], "left"))
            end = len(self) if ends[1] is None else int(numpy.searchsorted(self.ticks, ends[1], "right"))
            return list(range(begin, end))[:: ticks.step or 1]
        if isinstance(ticks, str):
            if ticks != "all":
                raise ValueError(f"ticks are {ticks!r}; there are numbers, slices, lists and \"all\"")
            return list(range(len(self)))
        if ticks is None or isinstance(ticks, (int, numpy.integer)):
            return [self.step_of(None if ticks is None else int(ticks))]
        return [self.step_of(tick) for tick in ticks]

    # ---- what is recorded

    def frame(self, tick: Optional[int] = None, method: Optional[str] = None) -> pandas.DataFrame:
        """All catoms in a tick, a row for each, in the order of their numbers.

        Parameters
        ----------
        tick, method
            Of a recorded tick; see the class.

        Returns
        -------
        pandas.DataFrame
            "catom" (int64); "x", "y", "z", in diameters of a catom (float32); "red", "green", "blue" (uint8); "label" and
            "diameter" if they are recorded; of amoebots "tail_x", "tail_y", "tail_z", where the other cell is, or the only one; of bodies
            that are not all spheres "core_x", "core_y", "core_z", "rounding", half the edges of each one's core (of a cylinder its
            radius, 0 and half its height) and the radius around it, in diameters, and "orientation_w", "orientation_x",
            "orientation_y", "orientation_z", how it is turned (float64), which is also there where joints hold spheres; of a compound
            "core_x" is the radius of the ball around it, and "rounding" minus its place among those of the world, from 1;
            "load.evaluations" and "load.messages" if the run was counted. Then for each recorded
            predicate: of one without arguments whether it holds (bool); of one with one argument its value, in a column of its name,
            and of several in NAME.ARGUMENT (Int64, float64, boolean or objects; missing where there is no fact); of one with several
            facts at a catom their number, in NAME.facts. `attrs["tick"]` is the tick.
        """
        step = self.step_of(tick, method)
        steps = self._steps
        columns: dict[str, Any] = {"catom": steps.array("id", step), **dict(zip("xyz", steps.positions(step).T)),
                                   **dict(zip(("red", "green", "blue"), steps.array("colour", step).T))}
        if "label" in steps.arrays:
            columns["label"] = pandas.Series(steps.strings("label", steps.array("label", step)), dtype=object)
        for name, parts in PARTS.items():
            if name in steps.arrays and name not in steps.predicates:
                columns.update(zip(parts, steps.array(name, step).T))
        for name in ("diameter", "load.evaluations", "load.messages"):
            if name in steps.arrays and name not in steps.predicates:
                columns[name] = steps.array(name, step)
        for name, predicate in steps.predicates.items():
            columns.update(self._held(name, predicate, step))
        frame = pandas.DataFrame(columns)
        frame.attrs["tick"] = int(self.ticks[step])
        return frame

    def frames(self, ticks: Ticks = "all") -> Iterator[tuple[int, pandas.DataFrame]]:
        """Of each of these recorded ticks, the tick and the frame; one at a time is in memory."""
        for step in self.steps_of(ticks):
            tick = int(self.ticks[step])
            yield tick, self.frame(tick)

    def joints(self, tick: Optional[int] = None, method: Optional[str] = None) -> pandas.DataFrame:
        """The joints in a tick, as they are in the world: a row for each that there was in this recorded tick or in one before.

        Parameters
        ----------
        tick, method
            Of a recorded tick; see the class.

        Returns
        -------
        pandas.DataFrame
            "first" and "second", the two catoms (int64); "kind" ("hinge", "slider" or "ball"); "fate": it "holds", is "broken" (or a
            program took it off), or is "gone" with one of its catoms. Where it is as the second catom holds it, "x", "y", "z", in
            diameters; "slid", how far that is from where the first one holds it, along the axis, in diameters, of a hinge and a ball 0;
            and the axis, "axis_x", "axis_y", "axis_z" (float64; of a ball missing). Of a joint that is gone, all these are missing.
            `attrs["tick"]` is the tick. Empty if the world has no joints, or the recording was made before joints were recorded.
        """
        step = self.step_of(tick, method)
        steps = self._steps
        rows = steps.joint_rows(step) if steps.has_joints else {
            **{name: numpy.empty(0, "int64") for name in ("first", "second", "kind", "fate")},
            **{name: numpy.empty((0, 3)) for name in ("first_anchor", "second_anchor", "axis")}}
        ids, places = steps.array("id", step), steps.positions(step).astype("float64")
        turns = steps.array("orientation" if "core" in steps.arrays else "joint.orientation", step) if steps.has_joints else places
        held = []
        for end in ("first", "second"):
            at = numpy.minimum(numpy.searchsorted(ids, rows[end]), max(len(ids) - 1, 0))
            there = ids[at] == rows[end] if len(ids) else numpy.zeros(len(at), bool)
            place = numpy.where(there[:, None], places[at], numpy.nan)
            held.append((place + _turned(turns[at], rows[f"{end}_anchor"]), turns[at]))
        (first, turn), (second, _) = held
        axis = _turned(turn, rows["axis"])
        axis[numpy.isnan(first).any(axis=1)] = numpy.nan
        slides = rows["kind"] == KINDS.index("slider")
        frame = pandas.DataFrame({
            "first": rows["first"], "second": rows["second"], "kind": [KINDS[number] for number in rows["kind"]],
            "fate": [FATES[number] for number in rows["fate"]], **dict(zip("xyz", second.T)),
            "slid": numpy.where(slides, ((second - first) * axis).sum(axis=1), 0 * second[:, 0]),
            **dict(zip(("axis_x", "axis_y", "axis_z"), axis.T))})
        frame.loc[frame["fate"] == FATES[2], ["x", "y", "z", "slid", "axis_x", "axis_y", "axis_z"]] = numpy.nan
        frame.attrs["tick"] = int(self.ticks[step])
        return frame

    def facts(self, predicate: str, tick: Ticks = None) -> pandas.DataFrame:
        """The facts of a predicate in a tick, as `claymeld.facts` has them: "catom", and the arguments by name.

        Parameters
        ----------
        predicate : str
            If it is not recorded, or the tick is not, the run is made again up to there; the last ticks so made are kept.
        tick : int, slice, list of int or "all"
            None: the last recorded. Of several, the first column is "tick"; a slice and "all" are of recorded ticks.

        Raises
        ------
        KeyError
            There is no such predicate, or the run ends before.
        """
        if tick is None or isinstance(tick, (int, numpy.integer)):
            return self._facts(predicate, tick)
        if isinstance(tick, (slice, str)):
            tick = [int(self.ticks[step]) for step in self.steps_of(tick)]
        frames = []
        for each in tick:
            frame = self._facts(predicate, each)
            frame.insert(0, "tick", int(self.ticks[self.step_of(each)]) if each < 0 else int(each))
            frames.append(frame)
        return pandas.concat(frames, ignore_index=True) if frames else pandas.DataFrame({"tick": [], "catom": []}, dtype="int64")

    def all_facts(self, tick: Optional[int] = None) -> dict[str, pandas.DataFrame]:
        """The facts of all predicates in a tick, by predicate; the run is made again."""
        found: dict[str, pandas.DataFrame] = read_facts(self._made_again(self._label(tick)))
        return found

    def metrics(self) -> pandas.DataFrame:
        """Numbers of each recorded tick, which is the index.

        Returns
        -------
        pandas.DataFrame
            "catoms"; "moved": how many catoms are elsewhere than in the step before; "appeared" and "gone" since then; for each recorded
            predicate "facts.NAME"; "load.evaluations" and "load.messages" if the run was counted; and "digest", of the whole state (str).
        """
        steps, rows = self._steps, []
        ids, places = numpy.empty(0, "int64"), numpy.empty((0, 3), "float32")
        for step in range(len(self)):
            row: dict[str, Any] = {"catoms": steps.count(step), "moved": 0, "appeared": 0, "gone": 0}
            if step == 0 or not steps.same_positions(step, step - 1):
                ids_now, places_now = steps.array("id", step), steps.positions(step)
                if step:
                    _, before, now = numpy.intersect1d(ids, ids_now, assume_unique=True, return_indices=True)
                    row.update(moved=int((places[before] != places_now[now]).any(axis=1).sum()), appeared=len(ids_now) - len(now),
                               gone=len(ids) - len(before))
                ids, places = ids_now, places_now
            row.update((f"facts.{name}", steps.fact_count(name, step)) for name in steps.predicates)
            for name in ("load.evaluations", "load.messages"):
                if name in steps.arrays and name not in steps.predicates:
                    row[name] = int(steps.array(name, step).sum())
            rows.append({**row, "digest": steps.digest(step)})
        return pandas.DataFrame(rows, index=pandas.Index(self.ticks, name="tick"))

    def events(self) -> pandas.DataFrame:
        """What came from outside by the world's [[event]] tables, up to the last recorded tick: a row for each tick, table and predicate.

        Returns
        -------
        pandas.DataFrame
            "tick" (Int64), "kind" ("give", "take", "kill", "hang", "restart", "cut", "heal", "join" or "jam"), "predicate" (only of
            "give" and "take"), and "what": the region, or the list of regions, arguments or numbers of catoms, of the world file. An
            event whose `time` is in ticks that the physics chooses is last, without a tick.
        """
        return planned.events(self.world, int(self.ticks[-1]) if len(self) else 0)

    # ---- questions, which meldsim answers

    def query(self, body: str, tick: Optional[int] = None) -> pandas.DataFrame:
        """All ways to satisfy a body, in Meld, after any tick of the run (None: its end): a column for each variable, a `vec3` in three.

        Raises
        ------
        WorldError
            The body is wrong; the message shows where.
        """
        return answers.query(self._target(), body, *self._at(tick), meldsim=self._meldsim)

    def why(self, fact: str, tick: Optional[int] = None, *, depth: Optional[int] = None, all: bool = False) -> Why:
        """Why a fact holds after a tick, `why("dist(@42, _)")`: a tree that notebooks show; it is false if the fact does not hold."""
        words = [*self._at(tick), *([] if depth is None else ["--depth", depth]), *(["--all"] if all else [])]
        return answers.why("why", self._target(), fact, *words, meldsim=self._meldsim)

    def why_not(self, fact: str, tick: Optional[int] = None, *, depth: Optional[int] = None) -> Why:
        """Why a fact does not hold after a tick: for each rule, the part of its body that fails; it is false if the fact holds."""
        words = [*self._at(tick), *([] if depth is None else ["--depth", depth])]
        return answers.why("why-not", self._target(), fact, *words, meldsim=self._meldsim)

    def history(self, fact: str, tick: Optional[int] = None) -> pandas.DataFrame:
        """The ticks in which facts came and went, up to a tick, `history("dist(@42, _)")`: a frame, with the rules."""
        return answers.history(self._target(), fact, *self._at(tick), meldsim=self._meldsim)

    def graph(self, facts: str = "neighbor(A, B)", tick: Optional[int] = None, *, multi: bool = False) -> Any:
        """A directed graph of networkx, of a predicate or a body in Meld.

        Parameters
        ----------
        facts : str
            A predicate whose facts name a catom in an argument: an edge leads there from the catom of the fact. Or a body, whose first two
            variables that are catoms are the ends. What else there is becomes attributes of the edges.
        tick : int
            None: the end.
        multi : bool
            A MultiDiGraph, which keeps several facts between the same two catoms; otherwise the last of them is kept.

        Returns
        -------
        networkx.DiGraph or networkx.MultiDiGraph
            Of all catoms, by number. If the tick is recorded, each has "pos", in diameters (x, y, z).
        """
        with needed_for("graph()"):
            import networkx

        if "(" in facts:
            frame = self.query(facts, tick)
            ends = [name for name, kind in frame.attrs["types"].items() if kind == "node"][:2]
        else:
            frame = self.facts(facts, tick)
            ends = ["catom"] + [name for name, kind in frame.attrs["types"].items() if kind == "node" and name != "catom"][:1]
        if len(ends) < 2:
            raise ValueError(f"there are no two catoms in {facts!r}, which has {', '.join(frame.columns) or 'nothing'}")
        graph = networkx.MultiDiGraph() if multi else networkx.DiGraph()
        try:
            step = self.step_of(tick)
            graph.add_nodes_from((int(i), {"pos": tuple(map(float, place))})
                                 for i, place in zip(self._steps.array("id", step), self._steps.positions(step)))
        except KeyError:
            graph.add_nodes_from(int(i) for i in self.query("id(A, I)", tick)["A"])
        others = [name for name in frame.columns if name not in ends]
        for row in frame.to_dict("records"):
            graph.add_edge(row[ends[0]], row[ends[1]], **{name: row[name] for name in others})
        return graph

    # ---- pictures

    def shot(self, tick: Union[int, str, Sequence[Union[int, str]], None] = None, **options: Any) -> pictures.Picture:
        """A picture, as `meldsim shot` takes it (docs/pictures.md), of any tick of the run or of several.

        `options` are those of the command, with "_" for "-": `colour="dist(A, D)"`, `size=(800, 600)`, `range=(0, 9)`, `ground=True`.
        """
        return pictures.shot(self._target(), self._shown(tick), options, self._meldsim)

    def movie(self, path: Path, **options: Any) -> pictures.Movie:
        """A film of the run in a file, as `meldsim movie` makes it; `options` as of shot().

        Raises
        ------
        ToolNotFound
            This meldsim makes no films.
        """
        return pictures.movie(self._target(), path, options, self._meldsim)

    def share(self, path: Path, **options: Any) -> pictures.Page:
        """Writes a page that shows the run in any browser, without a server (`meldsim view --share`).

        Raises
        ------
        ToolNotFound
            This meldsim writes no pages.
        """
        return pictures.share(self._target(), path, options, self._meldsim)

    def view(self, *, height: int = 520, live: bool = False, **options: Any) -> Union[pictures.Page, Live]:
        """The run as an interactive page in a notebook's cell: turned, zoomed, played, and asked for a catom's facts by a click. Of a
        recording that is still being written it shows what is there by now; view it again for more.

        Parameters
        ----------
        height : int
            Of the cell, in pixels.
        live : bool
            Whether a server stands behind it, as `meldsim view` has: then everything can be asked, at any tick, while this kernel runs
            and on this machine. Otherwise the page is in the notebook.
        **options
            Those of `meldsim view --share`, such as colour="dist(A, D)", facts="all", every=10; of a live page what is shown at first
            (colour, only, hide, links, arrows, labels, map, form) and the options of `meldsim view`, such as tick=10.

        Raises
        ------
        WorldError
            A body that is none of this program's, and other options that cannot be.
        LimitReached
            The page would be too large for a notebook: choose fewer frames (every=10) or share() it as a file.
        ToolNotFound
            This meldsim writes no pages.
        """
        if live:
            return Live([self._target()], height, options, self._meldsim, self)
        return pictures.view(self._target(), height, options, self._meldsim)

    def plot(self, tick: Optional[int] = None, colour: Any = None, **options: Any) -> Any:
        """A recorded tick in matplotlib's axes, which are returned; see `claymeld.plots.plot`, which has all options."""
        return plots.plot(self, tick, colour, **options)

    def plot_metrics(self, columns: Optional[Sequence[str]] = None, ax: Any = None, **options: Any) -> Any:
        """Columns of metrics() over the ticks (None: all that change), in matplotlib's axes, which are returned."""
        return plots.plot_metrics(self, columns, ax, **options)

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        return {"text/plain": repr(self), **pictures.display(self._target(), self._meldsim)}

    def _repr_html_(self) -> str:
        bundle = self._repr_mimebundle_()
        return str(bundle.get("text/html", f"<pre>{html.escape(repr(self))}</pre>"))

    # ---- within

    def _target(self) -> str:
        # What begins with a hyphen would be an option.
        return os.path.abspath(self.path)

    def _label(self, tick: Optional[int]) -> int:
        """The tick that is meant."""
        return int(self.ticks[self.step_of(tick)]) if tick is None or tick < 0 else int(tick)

    def _at(self, tick: Optional[int]) -> list[Any]:
        return ["--tick", self._label(tick)]

    def _shown(self, tick: Union[int, str, Sequence[Union[int, str]], None]) -> str:
        ticks = [tick] if tick is None or isinstance(tick, (int, str, numpy.integer)) else list(tick)
        return ",".join(str(each) if isinstance(each, str) else str(self._label(each)) for each in ticks)

    def _facts(self, predicate: str, tick: Optional[int]) -> pandas.DataFrame:
        if predicate in self._steps.predicates:
            try:
                return self._recorded(self._steps.predicates[predicate], self.step_of(tick))
            except KeyError:
                if tick is None or tick < 0:
                    raise
        frames = read_facts(self._made_again(self._label(tick)))
        if predicate not in frames:
            raise KeyError(f"the program has no facts named '{predicate}'; it has {', '.join(frames)}. What catoms sense is asked for by "
                           "query(), as in query('neighbor(A, B)')")
        found: pandas.DataFrame = frames[predicate]
        return found

    def _made_again(self, tick: int) -> str:
        """A file with all facts after a tick."""
        last = self._label(None)
        if tick > last:
            raise KeyError(f"{self.path} ends with tick {last}, before tick {tick}")
        with self._lock:
            if tick not in self._again:
                scratch = Scratch()
                path = str(scratch.folder / "facts.h5")
                call(["replay", self._target(), "--to", str(tick), "--facts-out", path, "--quiet"], meldsim=self._meldsim)
                self._again[tick] = (scratch, path)
                while len(self._again) > KEPT:
                    self._again.popitem(last=False)
            self._again.move_to_end(tick)
            return self._again[tick][1]

    def _held(self, name: str, predicate: dict[str, Any], step: int) -> dict[str, Any]:
        """What a predicate says of each catom, as columns of a frame."""
        arguments = predicate["arguments"]
        if not arguments:
            return {name: self._steps.array(name, step) > 0}
        counts = self._steps.array(f"{name}.facts", step)
        if predicate["table"]:
            return {f"{name}.facts": counts}
        columns: dict[str, Any] = {}
        for argument in arguments:
            column = name if len(arguments) == 1 else f"{name}.{argument['name']}"
            cells, kind = self._steps.array(argument["array"], step), argument["type"]
            if kind == "vec3":
                columns.update((f"{column}.{axis}", cells[:, number]) for number, axis in enumerate("xyz"))
            elif kind == "float":
                columns[column] = numpy.where(counts > 0, cells.astype("float64"), numpy.nan)
            elif kind in NUMBERS:
                dtype = "boolean" if kind == "bool" else "Int64"
                columns[column] = pandas.Series(cells.astype(NUMBERS[kind])).astype(dtype).mask(counts == 0)
            else:
                texts = self._steps.strings(argument["array"], cells)
                columns[column] = pandas.Series([None if text is None else value(text) for text in texts], dtype=object)
        return columns

    def _recorded(self, predicate: dict[str, Any], step: int) -> pandas.DataFrame:
        cells = self._steps.fact_rows(predicate["name"], step)
        columns: dict[str, Any] = {"catom": cells["catom"]}
        types = {"catom": "node"}
        for argument in predicate["arguments"]:
            name, kind = argument["name"], argument["type"]
            types[name] = kind
            if kind == "vec3":
                columns.update((f"{name}.{axis}", cells[name][:, number]) for number, axis in enumerate("xyz"))
            elif kind in NUMBERS:
                columns[name] = cells[name].astype(NUMBERS[kind])
            else:
                texts = self._steps.strings(argument["array"], cells[name])
                columns[name] = pandas.Series([value(text or "") for text in texts], dtype=object)
        frame = pandas.DataFrame(columns)
        frame.attrs["types"] = types
        return frame


def _turned(turns: Any, ways: Any) -> Any:
    """Ways (rows, 3) in frames that are turned by (rows, 4), w, x, y, z, as they are in the world."""
    real, axis = turns[:, :1], turns[:, 1:]
    across = 2 * numpy.cross(axis, ways)
    return ways + real * across + numpy.cross(axis, across)
