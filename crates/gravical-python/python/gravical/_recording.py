"""Recordings."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from . import _gravical, _tables
from ._errors import usage
from ._findings import Finding
from ._types import Floats, Path, Reading, options, text

if TYPE_CHECKING:
    from typing_extensions import Unpack


class Recording(_tables.Columns):
    """Samples of one sensor in columns, with what is known of them.

    Made by :func:`gravical.read`, :meth:`from_arrays`, or a table that is given to any function.
    Values are in the unit of the file; an empty cell is NaN. Arrays are read-only views of the
    recording's own memory, which lives as long as they do.

    Attributes
    ----------
    t : array of shape (n,) or None
        Seconds since the first row; None without usable time stamps.
    ax, ay, az : array of shape (n,)
        Specific force, in ``accel_unit``, less ``zero_offset``.
    gx, gy, gz : array of shape (n,) or None
        Angular rate, in ``gyro_unit``; None without a gyroscope.
    temperature : array of shape (n,) or None
        Temperature of the sensor, °C.
    """

    __slots__ = ("_native",)
    _native: _gravical.Recording

    def __init__(self, native: _gravical.Recording) -> None:
        if not isinstance(native, _gravical.Recording):
            raise usage(
                "a recording is not made of this",
                "use gravical.read(path) or Recording.from_arrays(t=…, accel=…)",
            )
        self._native = native

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
        **reading: Unpack[Reading],
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
            How samples are read: see :class:`Reading`.

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
        text(name, "name")
        xyz = _tables.vectors(accel, "accel")
        names, columns = ["ax", "ay", "az"], list(xyz.T)
        if gyro is not None:
            names += ["gx", "gy", "gz"]
            columns += list(_tables.vectors(gyro, "gyro", len(xyz)).T)
        if temperature is not None:
            names.append("temperature_c")
            columns.append(_tables.scalars(temperature, "temperature", len(xyz)))
        if t is not None:
            names.insert(0, "t")
            columns.insert(0, _tables.scalars(t, "t", len(xyz)))
            if np.asarray(t).dtype.kind in "Mm" and reading.get("time_unit") is None:
                reading["time_unit"] = "s"
        given: list[Any] = [_tables.floats(column) for column in columns]
        if labels is not None:
            try:
                texts = [str(label) for label in labels]
            except TypeError:
                raise usage("labels= is no list of texts") from None
            if len(texts) != len(xyz):
                raise usage(
                    f"labels= has {len(texts)} texts, accel= has {len(xyz)} samples",
                    "give one label for every sample",
                    code="samples-length",
                )
            names.append("label")
            given.append(texts)
        if unit is not None:
            if reading.get("accel_unit") not in (None, unit):
                raise usage("unit= and accel_unit= differ", "give one of the two")
            reading["accel_unit"] = unit  # type: ignore[typeddict-item]
        return cls(_gravical.Recording.from_table(name, names, given, options(reading)))

    @classmethod
    def from_table(
        cls, table: Any, *, name: str = "table", **reading: Unpack[Reading]
    ) -> Recording:
        """A recording of a table in memory, its columns recognised as those of a file.

        Parameters
        ----------
        table : DataFrame of pandas or polars, Arrow table, or mapping from names to arrays
            Dates, integers and columns of texts with the labels of poses are understood. The index
            of a pandas frame is used if it holds dates.
        name : str
            Name in messages.
        **reading
            How it is read: see :class:`Reading`; ``columns`` names what is not recognised.

        Raises
        ------
        InputError
            ``no-accelerometer``, ``columns-unknown`` if the columns are not recognised.

        Examples
        --------
        >>> import numpy as np
        >>> rest = np.ones(200)
        >>> table = {"acc_x": 0 * rest, "acc_y": 0 * rest, "acc_z": rest}
        >>> Recording.from_table(table, rate=50).accel_unit
        'g'
        """
        names, columns, dated = _tables.table_columns(table)
        text(name, "name")
        if dated and reading.get("time_unit") is None:
            reading["time_unit"] = "s"
        return cls(_gravical.Recording.from_table(name, names, columns, options(reading)))

    @property
    def name(self) -> str:
        """Path of the file as given, or the name of the recording."""
        return self._native.name

    @property
    def description(self) -> str:
        """How it was read, in words."""
        return self._native.description

    @property
    def rows(self) -> int:
        """Number of samples."""
        return self._native.rows

    def __len__(self) -> int:
        return self._native.rows

    @property
    def columns(self) -> dict[str, Floats]:
        """All channels by name, as read-only views: ``t``, ``ax`` … ``gz``, ``temperature``."""
        return {name: self._native.channel(name) for name in self._native.channels()}

    @property
    def column_names(self) -> list[str]:
        """Names of the columns of the file or table; empty without a header."""
        return self._native.column_names

    def __getitem__(self, channel: str) -> Floats:
        return self._native.channel(channel)

    def _channel(self, name: str) -> Floats | None:
        return self._native.channel(name) if name in self._native.channels() else None

    @property
    def t(self) -> Floats | None:
        """Seconds since the first row; None without usable time stamps."""
        return self._channel("t")

    @property
    def ax(self) -> Floats:
        """Specific force along x."""
        return self._native.channel("ax")

    @property
    def ay(self) -> Floats:
        """Specific force along y."""
        return self._native.channel("ay")

    @property
    def az(self) -> Floats:
        """Specific force along z."""
        return self._native.channel("az")

    @property
    def gx(self) -> Floats | None:
        """Angular rate about x."""
        return self._channel("gx")

    @property
    def gy(self) -> Floats | None:
        """Angular rate about y."""
        return self._channel("gy")

    @property
    def gz(self) -> Floats | None:
        """Angular rate about z."""
        return self._channel("gz")

    @property
    def temperature(self) -> Floats | None:
        """Temperature, °C."""
        return self._channel("temperature")

    @property
    def accel(self) -> Floats:
        """Specific force, shape (n, 3): a new array, as the columns are stored one by one."""
        return np.stack([self.ax, self.ay, self.az], axis=1)

    @property
    def gyro(self) -> Floats | None:
        """Angular rate, shape (n, 3): a new array; None without a gyroscope."""
        if "gx" not in self._native.channels():
            return None
        return np.stack([self[name] for name in ("gx", "gy", "gz")], axis=1)

    @property
    def labels(self) -> list[str] | None:
        """Label of each row; None without a column of labels."""
        found = self._native.labels()
        if found is None:
            return None
        names, of_row = found
        return [names[i] for i in of_row]

    @property
    def accel_unit(self) -> str:
        """Unit of the accelerometer: ``m/s^2``, ``g``, ``mg``, ``counts`` or ``unknown``."""
        return self._native.accel_unit

    @property
    def gyro_unit(self) -> str | None:
        """Unit of the gyroscope: ``rad/s``, ``deg/s``, ``counts`` or ``unknown``."""
        return self._native.gyro_unit

    @property
    def zero_offset(self) -> float:
        """What was subtracted from the accelerometer's counts."""
        return self._native.zero_offset

    @property
    def rate_hz(self) -> float | None:
        """Sampling rate, Hz, of the time stamps, otherwise as given."""
        return self._native.rate_hz

    @property
    def breaks(self) -> list[int]:
        """Rows that do not continue the row before."""
        return self._native.breaks

    @property
    def recorded(self) -> str | None:
        """When it begins (RFC 3339, UTC), if the time stamps are dates."""
        return self._native.recorded

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is odd, with the lines."""
        return Finding._all(json.loads(self._native.findings_json()))

    def _named(self) -> dict[str, Floats]:
        return self.columns

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickled, (self._native.to_bytes(),)

    def __repr__(self) -> str:
        rate = f", {self.rate_hz:.6g} Hz" if self.rate_hz else ""
        gyro = f", gyroscope in {self.gyro_unit}" if self.gyro_unit else ""
        return f"<Recording {self.name!r}: {self.rows} rows{rate}, {self.accel_unit}{gyro}>"



#: A path, a recording, or a table: a data frame of pandas or polars, an object with
#: ``__arrow_c_stream__``, or a mapping from column names to arrays.
Source = Union[Path, Recording, Mapping[str, Any], Any]


def _unpickled(data: bytes) -> Recording:
    return Recording(_gravical.Recording.from_bytes(data))


def read(
    source: Source, *, gyro: Path | None = None, name: str | None = None, **reading: Unpack[Reading]
) -> Recording:
    """Read a recording.

    Parameters
    ----------
    source : path, bytes, binary file, or table
        Text or CSV in any of the formats that the program reads, plain or ``.gz``; the content of
        such a file; or a table in memory (:meth:`Recording.from_table`).
    gyro : path, optional
        Gyroscope of the recording in a second file, joined by time.
    name : str, optional
        Name in messages, for what has none of its own.
    **reading
        How it is read where it does not say so itself: see :class:`Reading`.

    Returns
    -------
    Recording

    Raises
    ------
    NotFoundError
        There is no such file.
    InputError
        The file holds no recording: ``no-rows``, ``no-accelerometer``, ``columns-unknown`` …
    UsageError
        ``option-range`` for a rate or range that no sensor has.

    Examples
    --------
    >>> text = b"t_ms,ax,ay,az\\n0,0.1,0.0,9.8\\n10,0.1,0.1,9.8\\n20,0.1,0.0,9.7\\n"
    >>> gravical.read(text)
    <Recording 'bytes': 3 rows, 100 Hz, m/s^2>
    """
    if name is not None:
        text(name, "name")
    if isinstance(source, Recording):
        if reading or gyro is not None:
            raise usage(
                "the recording is read already; what says how it is read comes too late",
                "give these arguments where the recording is made",
            )
        return source if name is None else Recording(source._native.named(name))
    if _tables.is_table(source):
        if gyro is not None:
            raise usage("gyro= joins two files", "put the gyroscope into the table")
        return Recording.from_table(source, name=name or "table", **reading)
    if hasattr(source, "read"):
        file: Any = source
        source, name = file.read(), name or str(getattr(file, "name", "file"))
    if isinstance(source, (bytes, bytearray, memoryview)):
        if gyro is not None:
            raise usage("gyro= joins two files", "write the recording to a file first")
        given = options(reading)
        return Recording(_gravical.read_bytes(bytes(source), name or "bytes", given))
    beside = None if gyro is None else path_of(gyro)
    recording = _gravical.read(path_of(source), beside, options(reading))
    return Recording(recording if name is None else recording.named(name))


def path_of(source: Any) -> Path:
    """The path, or an error that says what else there could be."""
    if isinstance(source, (str, os.PathLike)):
        return source
    raise usage(
        f"a {type(source).__name__} is no recording",
        "give a path, a Recording, a data frame, a mapping of columns, "
        "or arrays through Recording.from_arrays(t=…, accel=…)",
    )


def session_of(
    session: Any, reading: Reading
) -> tuple[list[Path] | None, list[_gravical.Recording] | None]:
    """The recordings of a session: paths, or what is in memory."""
    if isinstance(session, (str, os.PathLike)):
        return [session], None
    if isinstance(session, Mapping) and not _is_columns(session):
        named = [read(value, name=str(key), **reading) for key, value in _poses(session)]
        return None, [r._native for r in named]
    if isinstance(session, Recording) or _tables.is_table(session):
        return None, [read(session, **reading)._native]
    try:
        all_of = list(session)
    except TypeError:
        all_of = []
    if not all_of:
        if not isinstance(session, (list, tuple)):
            path_of(session)
        raise usage("the session is empty", "give the recordings of the sensor at rest")
    if all(isinstance(one, (str, os.PathLike)) for one in all_of):
        return all_of, None
    made = [one if isinstance(one, Recording) else read(one, **reading) for one in all_of]
    return None, [one._native for one in made]


def _is_columns(mapping: Mapping[Any, Any]) -> bool:
    """True for columns of one table, false for recordings by the name of their pose."""

    def is_one(value: Any) -> bool:
        return not isinstance(value, (str, os.PathLike, Recording, Mapping)) and (
            not _tables.is_pandas(value)
            and not hasattr(value, "get_columns")
            and np.ndim(value) <= 1
        )

    return all(is_one(value) for value in mapping.values())


def _poses(session: Mapping[Any, Any]) -> list[tuple[Any, Any]]:
    """Recordings by pose; an array of shape (n, 3) is the accelerometer alone."""
    out: list[tuple[Any, Any]] = []
    for key, value in session.items():
        if isinstance(value, np.ndarray) or isinstance(value, list):
            xyz = _tables.vectors(value, str(key))
            value = {"ax": xyz[:, 0], "ay": xyz[:, 1], "az": xyz[:, 2]}
        out.append((key, value))
    return out
