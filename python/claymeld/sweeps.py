"""Runs over a grid of worlds, parameters and seeds, or those of a study: claymeld.sweep()."""

from __future__ import annotations

import concurrent.futures
import contextlib
import itertools
import os
import pathlib
import sqlite3
import sys
import threading
from typing import Any, Callable, Iterable, Mapping, Optional, Sequence, Union

import pandas

from .data.sources import World
from .running import Call, Run
from .tool.calls import Child, Path, find, wants_progress
from .tool.errors import Interrupted, MeldsimError, error

Parameters = Union[Mapping[str, Sequence[Any]], Iterable[Mapping[str, Any]]]


def sweep(program: Path, worlds: Any = None, parameters: Parameters = (), seeds: Union[int, Iterable[int], None] = None, *,
          workers: Optional[int] = None, measure: Optional[Callable[[Run], Mapping[str, Any]]] = None, record: bool = False,
          progress: Optional[bool] = None, **options: Any) -> pandas.DataFrame:
    """Runs a program in every world with all combinations of parameters and seeds, several at once; or makes the runs of a study that
    are missing, as `meldsim sweep` does.

    Parameters
    ----------
    program : path or str
        As of run(). A `.toml` file is a study, which says everything else; only `workers`, `progress` and `meldsim` go with it.
    worlds : world, list of worlds, or dict of them by name
        Each as of run(). A dict with a key "body" or "lattice" is one world.
    parameters : dict of lists, or list of dicts
        Of each constant of the program the values, which are all combined; or the combinations.
    seeds : int or iterable of int
        So many, from 1 on; or which. None: the world's.
    workers : int
        Runs at a time; None: as many as there are processors for their processes and threads.
    measure : callable
        Called with each run that ends well, in a thread; what it returns, a dict, becomes columns of the run's row.
    record : bool
        Whether `measure` finds recordings.
    progress : bool
        Whether a line shows how many runs are done; None: on a terminal.
    **options
        Of run(): ticks, until, expect, processes, predicates and so on.

    Returns
    -------
    pandas.DataFrame
        A row for each run, in the order of worlds, parameters and seeds, whatever finished first: "world", the name, path or number of the
        world; the parameters, by name; "seed"; the numbers and texts of the summary; what `measure` returns; "error", the kind of the
        exception, and "message". Of a run that ends well these two are missing; one that fails is a row as well.
        Of a study: the rows that `meldsim sweep` writes, with its columns.

    Raises
    ------
    Interrupted
        Ctrl-C: the runs at work have ended, and the others do not begin. Of a study, what has been made is kept.
    MeldsimError
        The study has a mistake.
    """
    if os.fspath(program).endswith(".toml"):
        if worlds is not None or parameters or seeds is not None or measure is not None or record or set(options) - {"meldsim"}:
            raise TypeError(f"{os.fspath(program)} is a study, which says all this itself: give only workers, progress and meldsim with it")
        return _study(program, workers, progress, options.get("meldsim"))
    chosen: list[Optional[int]] = [None] if seeds is None else list(range(1, seeds + 1) if isinstance(seeds, int) else seeds)
    jobs = [{"world": name, "of": world, "set": values, "seed": seed}
            for (name, world), values, seed in itertools.product(_worlds(worlds), _combinations(parameters), chosen)]
    room = max((os.cpu_count() or 1) // (int(options.get("processes", 1)) * int(options.get("threads", 1))), 1)
    shown = wants_progress(progress) and sys.stderr is not None
    at_work: set[Child] = set()
    lock, stop = threading.Lock(), threading.Event()

    def one(job: Mapping[str, Any]) -> dict[str, Any]:
        row = {"world": job["world"], **job["set"], "seed": job["seed"]}
        try:
            call = Call(program, job["of"], {"record": record, "facts": measure is not None, **options, "seed": job["seed"],
                                             "constants": {**options.get("constants", {}), **job["set"]}})
            with lock:
                if stop.is_set():
                    return row
                child = call.start()
                at_work.add(child)
            done = child.wait()
            with lock:
                at_work.discard(child)
            run = call.finish(done)
            row.update(_numbers(run))
            row.update(measure(run) if measure is not None else {})
        except Interrupted:
            pass
        except MeldsimError as problem:
            if problem.run is not None:
                row.update(_numbers(problem.run))
            row.update(error=type(problem).__name__, message=problem.message)
        except Exception as problem:  # Of `measure`, or of a parameter that Meld has no value for: the other runs go on.
            row.update(error=type(problem).__name__, message=str(problem))
        return row

    rows: list[dict[str, Any]] = []
    with concurrent.futures.ThreadPoolExecutor(min(workers or room, len(jobs) or 1)) as pool:
        waiting = [pool.submit(one, job) for job in jobs]
        try:
            for number, _ in enumerate(concurrent.futures.as_completed(waiting), 1):
                if shown:
                    print(f"\rsweep: {number} of {len(jobs)} runs", end="", file=sys.stderr, flush=True)
            rows = [future.result() for future in waiting]
        except KeyboardInterrupt:
            with lock:
                stop.set()
                for child in at_work:
                    child.interrupt()
            raise Interrupted() from None
        finally:
            if shown:
                print(file=sys.stderr)
    frame = pandas.DataFrame([{key: row[key] for key in row if key not in ("error", "message")} for row in rows])
    for column in ("error", "message"):
        frame[column] = pandas.Series([row.get(column) for row in rows], dtype=object)
    return frame


def _study(study: Path, workers: Optional[int], progress: Optional[bool], meldsim: Optional[Path]) -> pandas.DataFrame:
    """The rows of a study, those that were missing now made."""
    path = os.fspath(study)
    shown = wants_progress(progress)
    command = [find(meldsim), "sweep", path if not path.startswith("-") else os.path.join(".", path)]
    command += [] if workers is None else ["--jobs", str(workers)]
    done = Child(command if shown else [*command, "--quiet"], shown).wait()
    if done.interrupted:
        raise Interrupted(None, command)
    # Rows that have failed are rows.
    if done.code not in (0, 3):
        raise error(done.code, done.said, command)
    with contextlib.closing(sqlite3.connect(pathlib.Path(path).with_suffix(".results") / "rows.sqlite")) as database:
        return pandas.read_sql_query("SELECT * FROM rows", database)


def _numbers(run: Run) -> dict[str, Any]:
    """What of a summary has room in a cell."""
    return {key: item for key, item in run.summary.items() if isinstance(item, (int, float, str)) and key != "world"}


def _worlds(worlds: Any) -> list[tuple[Any, World]]:
    if isinstance(worlds, Mapping) and not {"body", "lattice"} & set(worlds):
        return list(worlds.items())
    if isinstance(worlds, (list, tuple)):
        return [(_name(world, number), world) for number, world in enumerate(worlds)]
    return [(_name(worlds, 0), worlds)]


def _name(world: World, number: int) -> Any:
    """A path is its own name; what has none has its number."""
    is_text = isinstance(world, Mapping) or world is None or (isinstance(world, str) and ("\n" in world or "=" in world))
    return number if is_text else os.fspath(world)  # type: ignore[arg-type]


def _combinations(parameters: Parameters) -> list[dict[str, Any]]:
    if isinstance(parameters, Mapping):
        return [dict(zip(parameters, values)) for values in itertools.product(*parameters.values())]
    return [dict(values) for values in parameters] or [{}]
