"""Recordings."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _gravical
from ._arguments import Floats, is_path, is_table, keywords, table_columns, vectors
from ._errors import UsageError
from ._result import Record, axes_of, parsed

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from . import _types

CHANNELS = ("t", "ax", "ay", "az", "gx", "gy", "gz", "temperature")


class Recording:
    """Samples of one sensor in columns, with what is known of them.

    Made by :func:`gravical.read`, :meth:`from_arrays`, or a table that is given to any function.
    Values are in the unit of the file; an empty cell is NaN. Arrays are read-only views of the
    recording's own memory, which lives as long as they do; None without such a channel.
    """

    #: Seconds since the first row; None without usable time stamps.
    t: Floats | None
    #: Specific force, in ``accel_unit``, less ``zero_offset`` (of counts).
    ax: Floats
    ay: Floats
    az: Floats
    #: Angular rate, in ``gyro_unit``.
    gx: Floats | None
    gy: Floats | None
    gz: Floats | None
    #: Temperature of the sensor, °C.
    temperature: Floats | None
    #: Path or name, and how it was read, in words.
    name: str
    description: str
    rows: int
    #: Names of the columns of the file or table; empty without a header.
    column_names: list[str]
    #: ``m/s^2``, ``g``, ``mg``, ``counts``, or ``unknown``.
    accel_unit: str
    #: ``rad/s``, ``deg/s``, ``counts``, or ``unknown``.
    gyro_unit: str | None
    zero_offset: float
    #: Sampling rate, of the time stamps, otherwise as given.
    rate_hz: float | None
    #: Rows that do not continue the row before.
    breaks: list[int]
    #: When it begins (RFC 3339, UTC), if the time stamps are dates.
    recorded: str | None
    #: What is odd, with the lines: ``kind``, ``severity``, ``message``, ``lines``, ``count``.
    findings: list[Record]

    def __init__(self, native: Any, source: Any = None) -> None:
        if not isinstance(native, _gravical.Recording):
            hint = "use gravical.read(path) or Recording.from_arrays(t=…, accel=…)"
            raise UsageError("a recording is not made of this", hint=hint)
        self._native, self._source = native, source
        vars(self).update(dict.fromkeys(CHANNELS), **self.columns, **parsed(native.facts()))

    @classmethod
    def from_arrays(
        cls,
        *,
        accel: Any,
        t: Any = None,
        gyro: Any = None,
        temperature: Any = None,
        labels: Any = None,
        name: str = "recording",
        **reading: Unpack[_types.SamplesOptions],
    ) -> Recording:
        """A recording of samples in memory.

        - ``accel``, ``gyro``: specific force and angular rate along x, y, z: arrays of shape (n, 3),
          or tuples of three arrays. NaN where a value is missing.
        - ``t``: time stamps, shape (n,), numbers in ``time_unit`` (by default recognised by their
          steps) or ``datetime64``; without them give ``rate``.
        - ``temperature`` of the sensor, °C, shape (n,).
        - ``labels``: pose of each sample: ``+x``, ``-x`` …, or any name.
        - ``name`` and the keywords of :func:`gravical.read`.

        >>> import numpy as np
        >>> z_up = np.tile([0.0, 0.0, 9.81], (200, 1))
        >>> recording = Recording.from_arrays(t=np.arange(200) / 100, accel=z_up)
        >>> recording.rows, recording.rate_hz
        (200, 100.0)
        """
        columns = {"t": t, **dict(zip(("ax", "ay", "az"), vectors(accel, "accel").T))}
        if gyro is not None:
            columns.update(zip(("gx", "gy", "gz"), vectors(gyro, "gyro").T))
        columns.update(temperature_c=temperature, label=labels)
        given = {name: values for name, values in columns.items() if values is not None}
        return read(given, name=name, **reading)

    def __reduce__(self) -> tuple[Any, ...]:
        """A pickle holds the path of the file, and how it is read; there it is read again."""
        if self._source is None:
            hint = "save its data, or give the path of its file"
            raise UsageError("a recording in memory has no path to be pickled by", hint=hint)
        return _read_again, self._source

    def __dir__(self) -> list[str]:
        return [name for name in super().__dir__() if name.startswith("__") or name[0] != "_"]

    def plot(self, ax: Any = None) -> Any:
        """Draw the accelerometer on axes of matplotlib; returns them."""
        ax = axes_of(ax)
        at = np.arange(self.rows) if self.t is None else self.t
        for name in ("ax", "ay", "az"):
            ax.plot(at, getattr(self, name), label=name, linewidth=0.8)
        ax.set(xlabel="row" if self.t is None else "time (s)", ylabel=self.accel_unit)
        ax.legend()
        return ax

    @property
    def columns(self) -> dict[str, Floats]:
        """All channels by name: ``t``, ``ax`` … ``gz``, ``temperature``."""
        return dict(self._native.columns())

    @property
    def accel(self) -> Floats:
        """Specific force, shape (n, 3): a new array, as the columns are stored one by one."""
        return np.stack([self.ax, self.ay, self.az], axis=1)

    @property
    def gyro(self) -> Floats | None:
        """Angular rate, shape (n, 3): a new array; None without a gyroscope."""
        if self.gx is None:
            return None
        return np.stack([self[name] for name in ("gx", "gy", "gz")], axis=1)

    @property
    def labels(self) -> list[str] | None:
        """Label of each row; None without a column of labels."""
        found = self._native.labels()
        return None if found is None else [found[0][i] for i in found[1]]

    def to_pandas(self) -> Any:
        """All channels as a data frame of pandas."""
        import pandas

        return pandas.DataFrame(self.columns)

    def __getitem__(self, channel: str) -> Floats:
        return self.columns[channel]

    def __len__(self) -> int:
        return self.rows

    def __repr__(self) -> str:
        rate = f", {self.rate_hz:.6g} Hz" if self.rate_hz else ""
        gyro = f", gyroscope in {self.gyro_unit}" if self.gyro_unit else ""
        return f"<Recording {self.name!r}: {self.rows} rows{rate}, {self.accel_unit}{gyro}>"


def _read_again(path: str, name: str | None, reading: Any) -> Recording:
    return read(path, name=name, **reading)


def read(
    source: Any, *, name: str | None = None, **options: Unpack[_types.ReadOptions]
) -> Recording:
    """Read a recording. All keywords are optional: by default the file says it itself.

    - ``source``: path of text or CSV in any of the formats that the program reads, plain or ``.gz``,
      or of a ``.cwa``; the content of such a file; an array of shape (n, 3), or (n, 6) with a gyroscope;
      or a table in memory: a data frame of pandas or polars, or a mapping from names to arrays. Its columns are recognised as those of a file;
      dates, integers and columns of texts with the labels of poses are understood.
    - ``name`` in messages.
    - ``gyro``: path of the gyroscope in a second file, joined by time.
    - ``accel_unit``: ``"m/s^2"``, ``"g"``, ``"mg"``, ``"counts"``; ``gyro_unit``: ``"rad/s"``,
      ``"deg/s"``, ``"counts"``.
    - ``accel_range``, ``gyro_range``, ``zero_offset`` of counts: full scale in g and °/s; offset.
    - ``columns``: what each holds: ``{"t": "Timestamp", "ax": "acc_x", "gx": None}``, or in order
      ``"t,ax,ay,az,_,-"``.
    - ``sensor``: which of several in the file.
    - ``rate``, Hz, where there are no time stamps; ``time_unit``: ``"s"``, ``"ms"``, ``"us"``, ``"ns"``,
      ``"min"``, ``"h"``, ``"d"``.

    >>> text = b"t_ms,ax,ay,az\\n0,0.1,0.0,9.8\\n10,0.1,0.1,9.8\\n20,0.1,0.0,9.7\\n"
    >>> gravical.read(text)
    <Recording 'bytes': 3 rows, 100 Hz, m/s^2>
    """
    if name is not None and not isinstance(name, str):
        raise UsageError(f"name=: a {type(name).__name__} is no text")
    reading: dict[str, Any] = {**options}
    again = None
    if isinstance(source, Recording):
        if name is None and not reading:
            return source
        source = [source._native]
    elif is_path(source):
        again = os.path.abspath(source), os.fspath(source) if name is None else name, dict(reading)
        # In another folder, too, it is the same file.
        if (gyro := reading.get("gyro")) is not None and is_path(gyro):
            again[2]["gyro"] = os.path.abspath(gyro)
        source = [source]
    else:
        if hasattr(source, "read") and not is_table(source):
            source, name = source.read(), name or str(getattr(source, "name", "file"))
        if isinstance(source, (bytes, bytearray, memoryview)):
            source, name = bytes(source), name or "bytes"
        elif is_table(source := _channels(source)):
            names, columns, dated = table_columns(source)
            source, name = (names, columns), name or "table"
            reading = {"time_unit": "s", **reading} if dated else reading
        else:
            raise UsageError(
                f"a {type(source).__name__} is no recording",
                hint="give a path, a Recording, a data frame, a mapping of columns, "
                "an array of shape (n, 3), or arrays through Recording.from_arrays(t=…, accel=…)",
            )
    return Recording(_gravical.read(source, name, keywords(reading)), again)


def _channels(value: Any) -> Any:
    """The columns of an array: an accelerometer, and a gyroscope behind it."""
    if not isinstance(value, np.ndarray):
        return value
    if value.ndim == 2 and value.shape[1] == 6:
        accel, gyro = vectors(value[:, :3], "accel"), vectors(value[:, 3:], "gyro")
        return dict(zip(CHANNELS[1:], [*accel.T, *gyro.T]))
    return dict(zip(CHANNELS[1:], vectors(value, "accel").T))


def session_of(session: Any, options: dict[str, Any]) -> tuple[list[Any], dict[str, Any]]:
    """Its recordings for the native part, and the options that are left: paths alone are read there,
    as a session; with anything else in between each is read here."""
    parts: list[tuple[str | None, Any]] = [(None, session)]
    if isinstance(session, Mapping) and not _is_columns(session):
        parts = [(str(key), _pose(str(key), value)) for key, value in session.items()]
    elif isinstance(session, (list, tuple)):
        parts = [(None, one) for one in session]
    if not parts:
        raise UsageError("the session is empty", hint="give the recordings of the sensor at rest")
    if all(name is None and is_path(one) for name, one in parts):
        return [one for _, one in parts], options
    reading: Any = {}
    if not all(isinstance(one, Recording) for _, one in parts):
        reading = {key: options[key] for key in _gravical.READING if key in options}
    none: Any = {}
    sources = [
        read(one, name=name, **(none if isinstance(one, Recording) else reading))._native
        for name, one in parts
    ]
    return sources, {key: value for key, value in options.items() if key not in reading}


def _is_columns(mapping: Mapping[Any, Any]) -> bool:
    """True for columns of one table, false for recordings by the name of their pose."""

    def is_pose(one: Any) -> bool:
        return isinstance(one, Recording) or is_path(one) or is_table(one) or np.ndim(one) > 1

    return not any(map(is_pose, mapping.values()))


def _pose(name: str, value: Any) -> Any:
    """A recording; a list of rows is the accelerometer alone."""
    if isinstance(value, list):
        return dict(zip(("ax", "ay", "az"), vectors(value, name).T))
    return value
