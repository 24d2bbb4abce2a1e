"""Recordings."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _gravical, _tables
from ._errors import UsageError
from ._keywords import Floats, is_path, keywords
from ._result import Record, parsed

CHANNELS = ("t", "ax", "ay", "az", "gx", "gy", "gz", "temperature")


class Recording:
    """Samples of one sensor in columns, with what is known of them.

    Made by :func:`gravical.read`, :meth:`from_arrays`, or a table that is given to any function.
    Values are in the unit of the file; an empty cell is NaN. Arrays are read-only views of the
    recording's own memory, which lives as long as they do; None without such a channel.

    Attributes
    ----------
    t : array of shape (n,) or None
        Seconds since the first row; None without usable time stamps.
    ax, ay, az : array of shape (n,)
        Specific force, in ``accel_unit``, less ``zero_offset``.
    gx, gy, gz : array of shape (n,) or None
        Angular rate, in ``gyro_unit``.
    temperature : array of shape (n,) or None
        Temperature of the sensor, °C.
    name, description : str
        Path or name, and how it was read, in words.
    rows : int
        Number of samples.
    column_names : list of str
        Names of the columns of the file or table; empty without a header.
    accel_unit, gyro_unit : str
        ``m/s^2``, ``g``, ``mg``, ``counts``; ``rad/s``, ``deg/s``, ``counts``; or ``unknown``.
    zero_offset : float
        What was subtracted from the accelerometer's counts.
    rate_hz : float or None
        Sampling rate, of the time stamps, otherwise as given.
    breaks : list of int
        Rows that do not continue the row before.
    recorded : str or None
        When it begins (RFC 3339, UTC), if the time stamps are dates.
    findings : list of Record
        What is odd, with the lines: ``kind``, ``severity``, ``message``, ``lines``, ``count``.
    """

    if TYPE_CHECKING:
        t: Floats | None
        ax: Floats
        ay: Floats
        az: Floats
        gx: Floats | None
        gy: Floats | None
        gz: Floats | None
        temperature: Floats | None
        name: str
        description: str
        rows: int
        column_names: list[str]
        accel_unit: str
        gyro_unit: str | None
        zero_offset: float
        rate_hz: float | None
        breaks: list[int]
        recorded: str | None
        findings: list[Record]

    _native: _gravical.Recording

    def __init__(self, native: _gravical.Recording) -> None:
        if not isinstance(native, _gravical.Recording):
            hint = "use gravical.read(path) or Recording.from_arrays(t=…, accel=…)"
            raise UsageError("a recording is not made of this", hint=hint)
        self._native = native

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name in CHANNELS:
            return self._native.channel(name) if name in self._native.channels() else None
        facts = parsed(self._native.facts())
        if name not in facts:
            raise AttributeError(f"a recording has no {name!r}")
        return facts[name]

    @classmethod
    def from_arrays(
        cls,
        *,
        accel: Any,
        t: Any = None,
        gyro: Any = None,
        temperature: Any = None,
        labels: Any = None,
        unit: str | None = None,
        name: str = "recording",
        **reading: Any,
    ) -> Recording:
        """A recording of samples in memory.

        Parameters
        ----------
        accel : array of shape (n, 3), or a tuple of three arrays
            Specific force along x, y, z. NaN where a value is missing.
        t : array of shape (n,), optional
            Time stamps: numbers in ``time_unit`` (by default recognised by their steps) or
            ``datetime64``. Without them give ``rate``.
        gyro : array of shape (n, 3), optional
            Angular rate about x, y, z.
        temperature : array of shape (n,), optional
            Temperature of the sensor, °C.
        labels : sequence of str, optional
            Pose of each sample: ``+x``, ``-x`` …, or any name.
        unit : str, optional
            The same as ``accel_unit``: ``"m/s^2"``, ``"g"``, ``"mg"`` or ``"counts"``.
        name : str
            Name in messages.
        **reading
            As of :func:`gravical.read`.

        Raises
        ------
        UsageError
            ``samples-length`` for arrays of different lengths, and wrong shapes.
        InputError
            ``no-rows``, ``no-values``, ``all-zero``.

        Examples
        --------
        >>> import numpy as np
        >>> z_up = np.tile([0.0, 0.0, 9.81], (200, 1))
        >>> recording = Recording.from_arrays(t=np.arange(200) / 100, accel=z_up, unit="m/s^2")
        >>> recording.rows, recording.rate_hz
        (200, 100.0)
        """
        xyz = _tables.vectors(accel, "accel")
        columns: dict[str, Any] = {} if t is None else {"t": _tables.scalars(t, "t", len(xyz))}
        columns.update(zip(("ax", "ay", "az"), xyz.T))
        if gyro is not None:
            columns.update(zip(("gx", "gy", "gz"), _tables.vectors(gyro, "gyro", len(xyz)).T))
        if temperature is not None:
            columns["temperature_c"] = _tables.scalars(temperature, "temperature", len(xyz))
        if labels is not None:
            if isinstance(labels, (str, bytes)) or np.shape(labels) != (len(xyz),):
                message = f"labels=: {len(xyz)} texts are needed, one for every sample"
                raise UsageError(message, "samples-length")
            columns["label"] = [str(label) for label in labels]
        if unit is not None:
            if reading.get("accel_unit") not in (None, unit):
                raise UsageError("unit= and accel_unit= differ", hint="give one of the two")
            reading["accel_unit"] = unit
        if t is not None and np.asarray(t).dtype.kind in "Mm":
            reading.setdefault("time_unit", "s")
        return read(columns, name=name, **reading)

    @property
    def columns(self) -> dict[str, Floats]:
        """All channels by name: ``t``, ``ax`` … ``gz``, ``temperature``."""
        return {name: self._native.channel(name) for name in self._native.channels()}

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

    def to_polars(self) -> Any:
        """All channels as a data frame of polars."""
        import polars

        return polars.DataFrame(self.columns)

    def to_arrow(self) -> Any:
        """All channels as a table of Arrow, without copies; needs pyarrow."""
        import pyarrow

        columns = {name: pyarrow.array(values) for name, values in self.columns.items()}
        return pyarrow.table(columns)

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The Arrow PyCapsule interface; needs pyarrow."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)

    def __getitem__(self, channel: str) -> Floats:
        return self._native.channel(channel)

    def __len__(self) -> int:
        return self.rows

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._native.to_bytes(),)

    def __repr__(self) -> str:
        rate = f", {self.rate_hz:.6g} Hz" if self.rate_hz else ""
        gyro = f", gyroscope in {self.gyro_unit}" if self.gyro_unit else ""
        return f"<Recording {self.name!r}: {self.rows} rows{rate}, {self.accel_unit}{gyro}>"


def _unpickled(data: bytes) -> Recording:
    return Recording(_gravical.Recording.from_bytes(data))


def read(source: Any, *, name: str | None = None, **reading: Any) -> Recording:
    """Read a recording. All keywords are optional: by default the file says it itself.

    Parameters
    ----------
    source : path, bytes, binary file, or table
        Text or CSV in any of the formats that the program reads, plain or ``.gz``, or ``.cwa``; the
        content of such a file; or a table in memory: a data frame of pandas or polars, an Arrow
        table, or a mapping from names to arrays. Its columns are recognised as those of a file;
        dates, integers and columns of texts with the labels of poses are understood.
    name : str, optional
        Name in messages, for what has none of its own.
    gyro : path
        Gyroscope of the file in a second one, joined by time.
    accel_unit, gyro_unit : str
        ``"m/s^2"``, ``"g"``, ``"mg"``, ``"counts"``; ``"rad/s"``, ``"deg/s"``, ``"counts"``.
    accel_range, gyro_range : float
        Full scale in g and °/s, for raw counts.
    columns : str or mapping
        What each column holds: ``{"t": "Timestamp", "ax": "acc_x", "gx": None}``, or in order
        ``"t,ax,ay,az,_,-"``.
    sensor : str or int
        Which of several sensors in the file.
    rate : float
        Sampling rate in Hz, where there are no time stamps.
    time_unit : str
        ``"s"``, ``"ms"``, ``"us"`` or ``"ns"``.
    zero_offset : float
        Offset of raw counts.

    Raises
    ------
    NotFoundError
        There is no such file.
    InputError
        It holds no recording: ``no-rows``, ``no-accelerometer``, ``columns-unknown`` …
    UsageError
        ``option-range`` for a rate or range that no sensor has.

    Examples
    --------
    >>> text = b"t_ms,ax,ay,az\\n0,0.1,0.0,9.8\\n10,0.1,0.1,9.8\\n20,0.1,0.0,9.7\\n"
    >>> gravical.read(text)
    <Recording 'bytes': 3 rows, 100 Hz, m/s^2>
    """
    if name is not None and not isinstance(name, str):
        raise UsageError(f"name=: a {type(name).__name__} is no text")
    if isinstance(source, Recording) and not reading:
        return source if name is None else Recording(source._native.named(name))
    native, extra = native_source(source, name)
    return Recording(_gravical.read(native, keywords({**extra, **reading})))


def native_source(source: Any, name: str | None = None) -> tuple[Any, dict[str, Any]]:
    """A recording, or what it is made of, for the native part; and what is known of how to read it."""
    if isinstance(source, Recording):
        return (source if name is None else read(source, name=name))._native, {}
    if is_path(source):
        return (source if name is None else (name, source)), {}
    if hasattr(source, "read") and not _tables.is_table(source):
        source, name = source.read(), name or str(getattr(source, "name", "file"))
    if isinstance(source, (bytes, bytearray, memoryview)):
        return (name or "bytes", bytes(source)), {}
    if _tables.is_table(source):
        names, columns, dated = _tables.table_columns(source)
        return (name or "table", names, columns), {"time_unit": "s"} if dated else {}
    raise UsageError(
        f"a {type(source).__name__} is no recording",
        hint="give a path, a Recording, a data frame, a mapping of columns, "
        "or arrays through Recording.from_arrays(t=…, accel=…)",
    )


def session_of(session: Any, options: Mapping[str, Any]) -> tuple[list[Any], str]:
    """The recordings of a session for the native part, and the keywords."""
    parts: list[tuple[str | None, Any]]
    if isinstance(session, Mapping) and not _is_columns(session):
        parts = [(str(key), _pose(str(key), value)) for key, value in session.items()]
    elif isinstance(session, (list, tuple)):
        parts = [(None, one) for one in session]
    else:
        parts = [(None, session)]
    if not parts:
        raise UsageError("the session is empty", hint="give the recordings of the sensor at rest")
    made = [native_source(value, name) for name, value in parts]
    extra = {key: value for _, known in made for key, value in known.items()}
    return [source for source, _ in made], keywords({**extra, **options})


def _is_columns(mapping: Mapping[Any, Any]) -> bool:
    """True for columns of one table, false for recordings by the name of their pose."""

    def is_column(value: Any) -> bool:
        if is_path(value) or _tables.is_table(value):
            return False
        return np.ndim(value) <= 1

    return all(is_column(value) for value in mapping.values())


def _pose(name: str, value: Any) -> Any:
    """A recording; an array of shape (n, 3) is the accelerometer alone."""
    if isinstance(value, (np.ndarray, list)):
        return dict(zip(("ax", "ay", "az"), _tables.vectors(value, name).T))
    return value
