"""Arguments that several functions share."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, Literal, TypedDict, Union

import numpy as np
import numpy.typing as npt

from ._errors import usage

Path = Union[str, "os.PathLike[str]"]
Floats = npt.NDArray[np.float64]

AccelUnit = Literal["m/s^2", "m/s2", "mps2", "g", "mg", "counts"]
GyroUnit = Literal["rad/s", "deg/s", "dps", "counts"]
TimeUnit = Literal["s", "ms", "us", "ns"]


class Reading(TypedDict, total=False):
    """How a recording is read where it does not say so itself. All are optional.

    ``accel_unit``: unit of the accelerometer, by default from the data. ``accel_range``: its
    full-scale range in g, for raw counts. ``gyro_unit``, ``gyro_range`` (°/s): the same of the
    gyroscope. ``columns``: what each column holds, as a text (``"t=Timestamp,ax=acc_x,gx=-"``) or
    a mapping from channel to column. ``sensor``: which of several sensors in the file.
    ``rate``: sampling rate in Hz where there are no time stamps. ``time_unit``: unit of the time
    stamps. ``zero_offset``: offset of raw counts.
    """

    accel_unit: AccelUnit | None
    accel_range: float | None
    gyro_unit: GyroUnit | None
    gyro_range: float | None
    columns: str | Mapping[str, str | None] | None
    sensor: str | int | None
    rate: float | None
    time_unit: TimeUnit | None
    zero_offset: float | None


READING = frozenset(Reading.__annotations__)


def options(reading: Mapping[str, Any], **others: Any) -> dict[str, Any]:
    """Keyword arguments for the native part, without those that are None."""
    unknown = sorted(set(reading) - READING)
    if unknown:
        known = ", ".join(sorted(READING))
        raise TypeError(
            f"unexpected keyword argument {unknown[0]!r}; how a recording is read: {known}"
        )
    given = {name: value for name, value in {**reading, **others}.items() if value is not None}
    if "columns" in given:
        given["columns"] = _columns(given["columns"])
    for name in ("sensor", "recorded"):
        if name in given:
            given[name] = str(given[name])
    for name in ("axes", "rotation"):
        if name in given:
            given[name] = _joined(given[name])
    if "rests" in given:
        given["rests"] = _rests(given["rests"])
    for name in ("filter", "smooth", "free_pose", "face_pose", "thermal"):
        if name in given:
            given[name] = several(given[name])
    return given


def several(value: Any) -> list[Any]:
    """One value, or a list of them."""
    if isinstance(value, (str, bytes, os.PathLike)) or not isinstance(value, Iterable):
        return [value]
    try:
        return list(value)
    except TypeError:
        # An array without axes.
        return [value]


def _columns(columns: Any) -> str:
    if not isinstance(columns, Mapping):
        return _joined(columns)
    parts: list[str] = []
    for channel, column in columns.items():
        text = "-" if column is None else str(column)
        if any(mark in text for mark in ",="):
            raise usage(
                f"columns=: the column name {text!r} has a comma or an equals sign in it",
                "rename the column first, or give all columns in order: columns='t,ax,ay,az'",
            )
        parts.append(f"{channel}={text}")
    return ",".join(parts)


def _joined(value: Any) -> str:
    return value if isinstance(value, str) else ",".join(str(part) for part in several(value))


def _rests(rests: Any) -> str:
    if isinstance(rests, str):
        return rests
    spans: list[str] = []
    for span in several(rests):
        try:
            start, end = (None if t is None else float(t) for t in span)
        except (TypeError, ValueError):
            raise usage(
                f"rests=: {span!r} is not a pair of times",
                "give pairs of seconds, None for the end: rests=[(0, 5), (7.2, None)]",
            ) from None
        spans.append(f"{'' if start is None else repr(start)}-{'' if end is None else repr(end)}")
    return ",".join(spans)


def text(value: Any, name: str) -> str:
    """A text."""
    if isinstance(value, str):
        return value
    raise usage(f"{name}= is a {type(value).__name__}, not a text")
