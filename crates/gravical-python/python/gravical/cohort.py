"""Many recordings over an engine: Dask here, Ray and Spark in a few lines more.

The unit is one recording. Its result depends on its content, the options and the version of gravical
alone, and is written by renaming a complete file; a failure is a row. So a task may run anywhere, twice,
or again: the results are those of ``gravical calibrate --each``, and ``gravical collect OUT`` reads them.

:func:`submit` runs over a cluster of Dask. For another engine there are its parts: :class:`Run` makes tasks
and takes rows, and :func:`work` makes one of the other on any machine that sees the paths.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from itertools import islice
from typing import TYPE_CHECKING, Any

from . import _gravical
from ._calibration import Calibration, calibrate
from ._errors import Error, MachineError, usage
from ._recording import path_of
from ._types import Path, options as _given, several
from ._verbs import check, noise

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Row", "Run", "submit", "work"]

#: A row of a summary: ``name``, ``path``, ``status`` (``done``, ``poor``, ``error``), ``verdict``,
#: ``reason``, ``error_code``, ``hint``, ``result``, ``sha256``, and the values of the command.
Row = dict[str, Any]

#: Tasks in the hands of a cluster, for each of its threads: one that works and one that waits.
_WINDOW = 4

#: Options whose files belong to what decides about a result.
_FILES = ("sections", "thermal", "noise")
_COMMANDS = ("calibrate", "check", "apply", "noise")
#: These belong to one recording.
_ONE = ("gyro", "output", "force", "recorded")


class Run:
    """A run over many recordings, for any engine.

    It makes the folder and the journal, in which all items are planned; what has not come to a row is
    missing in ``gravical collect``. One run at a time may write to a folder. What is done there with
    the same content, options and version is not done again.

    Parameters
    ----------
    recordings : iterable of paths
        Files, or folders of sessions, as the machines see them.
    task : str
        ``"calibrate"``, ``"check"``, ``"apply"`` or ``"noise"``.
    out : path
        Folder for results and journals, which all machines see.
    force : bool
        Begin anew: do again what is done, and replace any file.
    **options
        Keyword arguments of the function ``task``; of check and apply also ``calibration``.

    Raises
    ------
    UsageError
        ``in-use``: another run writes to the folder; ``each-option``: an option of one recording.
    """

    def __init__(
        self,
        recordings: Iterable[Path],
        task: str,
        out: Path,
        *,
        force: bool = False,
        **options: Any,
    ) -> None:
        if task not in _COMMANDS:
            raise usage(f"{task!r} is no task", f"one of {', '.join(_COMMANDS)}")
        for name in _ONE:
            if name in options:
                raise usage(
                    f"{name}=: this belongs to one recording, not to many",
                    "leave it out",
                    code="each-option",
                )
        self._command = task
        files = [path for name in _FILES for path in _paths(options.get(name))]
        if task in ("check", "apply"):
            files += _paths(options.get("calibration"))
            options["calibration"] = _calibration(options.get("calibration"))
        self._options = _plain(options)
        words = _words({n: v for n, v in self._options.items() if n != "calibration"})
        if not files and "calibration" in options:
            # One in memory is known by its content.
            words.append(f"--calibration={options['calibration']}")
        folder = os.path.abspath(out)
        paths = [path_of(path) for path in recordings]
        self._native = _gravical.CohortRun(task, paths, folder, words, files, force)

    def __len__(self) -> int:
        return len(self._native)

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def task(self, index: int) -> str:
        """The task of a recording, as a text for :func:`work`."""
        native = self._native.task(index)
        return json.dumps([self._command, native, self._options])

    def tasks(self) -> Iterator[str]:
        """The task of each recording, in their order."""
        return map(self.task, range(len(self)))

    def take(self, index: int, row: Row) -> Row:
        """Notes the row that :func:`work` returned for the task ``index``."""
        self._native.take(index, json.dumps(row))
        return row

    def failed(self, index: int, code: str, message: str, hint: str | None = None) -> Row:
        """Notes that the task ``index`` came to no row; the row that says so."""
        row: Row = json.loads(self._native.failed(index, code, message, hint))
        return row

    def close(self) -> None:
        """Ends the run: another one may begin."""
        self._native.close()


def work(task: str) -> Row:
    """Do what a task says, in this process.

    Parameters
    ----------
    task : str
        Of :meth:`Run.task`.

    Returns
    -------
    dict
        The row. Whatever fails is a row with an ``error_code``; what is no error of gravical has the
        code ``internal``.

    Raises
    ------
    Error
        Nothing could be begun, and nothing noted: the folder of the results is not there, or full.
    """
    command, native, options = json.loads(task)
    item = _gravical.CohortItem.begin(native)
    row = item.row
    if row is None:
        path = json.loads(native)["item"]["path"]
        try:
            row = _done(item, command, path, options)
        except Error as error:
            row = item.failed(error.code, error.message, error.hint)
        except Exception as error:
            row = item.failed("internal", f"{type(error).__name__}: {error}", None)
    done: Row = json.loads(row)
    return done


def _done(item: _gravical.CohortItem, command: str, path: str, given: dict[str, Any]) -> str:
    if command == "calibrate":
        return item.calibrated(calibrate(path, **given)._native)
    if command == "noise":
        return item.found(noise(path, **given)._native)
    calibration = Calibration.from_json(given.pop("calibration"))
    if command == "check":
        return item.found(check(calibration, path, **given)._native)
    own = {n: given.pop(n, None) for n in ("keep_raw", "output_unit", "axes")}
    return item.applied(calibration._native, path, _given(given, **own))


def submit(
    client: Client,
    recordings: Iterable[Path],
    task: str,
    out: Path,
    *,
    force: bool = False,
    window: int | None = None,
    **options: Any,
) -> Iterator[Row]:
    """Run a command for many recordings over a cluster of Dask.

    Parameters
    ----------
    client : distributed.Client
        Its workers see the paths of the recordings and ``out``, and have gravical of this version.
    recordings, task, out, force, **options
        As of :class:`Run`.
    window : int, optional
        How many tasks the cluster has at a time, by default four for each thread of its workers. What a
        client and a scheduler hold does not grow with the number of recordings.

    Yields
    ------
    dict
        A row for each recording, as they are done. What is left when nobody takes rows any more is
        cancelled; the same call continues.

    Raises
    ------
    MachineError
        ``engine-lost``: the scheduler is gone. The same call with a new client continues.
    """
    return _rows(client, Run(recordings, task, out, force=force, **options), window)


def _rows(client: Any, run: Run, window: int | None) -> Iterator[Row]:
    distributed: Any = import_module("distributed")

    todo = enumerate(run.tasks())
    held: dict[Any, int] = {}

    def more(count: int) -> list[Any]:
        sent = [(client.submit(work, t, pure=False), i) for i, t in islice(todo, count)]
        held.update(sent)
        return [future for future, _ in sent]

    threads = sum(client.nthreads().values())
    try:
        done = distributed.as_completed(more(window or max(1, _WINDOW * threads)))
        for future in done:
            row = _row(run, held.pop(future), future, distributed.KilledWorker)
            future.release()
            done.update(more(1))
            yield row
    finally:
        if held and client.status == "running":
            client.cancel(list(held))
        run.close()


def _row(run: Run, index: int, future: Any, killed: type[Exception]) -> Row:
    if future.status in ("cancelled", "lost"):
        raise MachineError(
            "the engine lost a task that was not done: its scheduler is gone, or somebody cancelled it",
            code="engine-lost",
            hint="connect to a scheduler and call submit() again: what is done is skipped",
        )
    error = future.exception()
    if error is None:
        return run.take(index, future.result())
    if isinstance(error, killed):
        hint = "look at the logs of the workers: most often their memory was too small"
        return run.failed(index, "worker-died", f"its task ended several workers: {error}", hint)
    if isinstance(error, Error):
        return run.failed(index, error.code, error.message, error.hint)
    return run.failed(index, "internal", f"{type(error).__name__}: {error}")


def _is_path(value: Any) -> bool:
    return isinstance(value, (str, os.PathLike))


def _paths(value: Any) -> list[Path]:
    return [path for path in several(value) if _is_path(path)]


def _calibration(given: Any) -> str:
    if given is None:
        raise usage("calibration= is missing", "give a Calibration, or the path of its file")
    made = Calibration.load(given) if _is_path(given) else given
    if not isinstance(made, Calibration):
        raise usage(
            f"a {type(given).__name__} is no calibration",
            "give a Calibration, or the path of its file",
        )
    return made.to_json()


def _plain(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options that another machine can read."""
    try:
        plain: dict[str, Any] = json.loads(json.dumps(options, default=os.fspath))
    except (TypeError, ValueError) as error:
        raise usage(
            f"an option cannot be sent to another machine: {error}",
            "give texts, numbers, paths, and lists of them",
        ) from None
    return {name: value for name, value in plain.items() if value is not None}


def _words(options: Mapping[str, Any]) -> list[str]:
    """The options as the program names them."""
    words: list[str] = []
    for name, value in options.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(flag)
        elif value is not False:
            many = value if isinstance(value, list) else [value]
            words += [f"{flag}={one if isinstance(one, str) else json.dumps(one)}" for one in many]
    return words
