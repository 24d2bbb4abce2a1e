"""What a user gives, for the native part: keywords, arrays, tables of other libraries, none of which
has to be installed."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._errors import UsageError

Path = Union[str, "os.PathLike[str]"]
Floats = npt.NDArray[np.float64]


def is_path(value: Any) -> bool:
    """True for what names a file."""
    return isinstance(value, (str, os.PathLike))


def keywords(given: Mapping[str, Any]) -> str:
    """The keywords as JSON, without those that are None; the native part knows their forms and defaults."""
    plain = {name: _plain(name, value) for name, value in given.items() if value is not None}
    return json.dumps(plain)


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, float) and not math.isfinite(value):
        raise UsageError(f"{name}=: {value} is not finite")
    if value is None or isinstance(value, (str, int, float)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(name, part) for key, part in value.items()}
    if hasattr(value, "isoformat"):
        return value.isoformat()
    if isinstance(value, Iterable) and not isinstance(value, (bytes, bytearray)):
        return [_plain(name, part) for part in value]
    raise UsageError(f"{name}=: a {type(value).__name__} is no option")


def vectors(values: Any, name: str) -> Floats:
    """Three columns: an array of shape (n, 3), or a tuple of three arrays."""
    array = _numbers(values, name)
    if isinstance(values, tuple) and len(values) == 3 and array.ndim == 2:
        array = array.T
    if array.ndim != 2 or array.shape[1] != 3:
        turned = array.ndim == 2 and array.shape[0] == 3
        hint = f"transpose it: {name}.T" if turned else "one row for each sample, x, y and z in it"
        raise UsageError(f"{name}= has the shape {array.shape}; (n, 3) is needed", hint=hint)
    return array


def _numbers(values: Any, name: str) -> Floats:
    """Float64 without gaps; the same memory if it is that already."""
    try:
        return np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        hint = "give one row of numbers for each sample"
        raise UsageError(f"{name}= is no array of numbers: {error}", hint=hint) from None


def is_table(value: Any) -> bool:
    """True for a data frame of pandas or polars, or a mapping of columns."""
    return isinstance(value, Mapping) or hasattr(value, "columns") and hasattr(value, "to_numpy")


def table_columns(table: Any) -> tuple[list[str], list[Any], bool]:
    """Names and columns, each float64 without gaps or a list of texts; true if one held dates,
    which are seconds since 1970 now. A table whose names are 0, 1, 2 … has none."""
    named: list[tuple[Any, Any]]
    if isinstance(table, Mapping):
        named = list(table.items())
    else:
        # Of a data frame of pandas by position: names may repeat.
        named = list(table.items() if hasattr(table, "items") else ((n, table[n]) for n in table.columns))
        if "datetime" in str(getattr(getattr(table, "index", None), "dtype", "")):
            named.insert(0, (table.index.name or "time", table.index))
    if not named:
        hint = "give columns for x, y and z of the accelerometer"
        raise UsageError("the table has no columns", hint=hint)
    columns = [_column(str(name), values) for name, values in named]
    numbered = all(isinstance(name, (int, np.integer)) for name, _ in named)
    names = [] if numbered else [str(name) for name, _ in named]
    return names, [column for column, _ in columns], any(dated for _, dated in columns)


def _column(name: str, values: Any) -> tuple[Any, bool]:
    """Numbers or texts, and whether they are dates."""
    # Dates of pandas in a zone, datetime64[ns, Europe/Berlin], become UTC.
    words = str(getattr(values, "dtype", "")).split(",")
    is_zoned = words[0].startswith("datetime64[") and len(words) > 1
    hint = "give one number for each row: an array with one axis"
    try:
        array = np.asarray(values, "datetime64[ns]" if is_zoned else None)
    except ValueError as error:
        raise UsageError(f"column {name!r} is no array: {error}", hint=hint) from None
    if array.ndim != 1:
        raise UsageError(f"column {name!r} has the shape {array.shape}", hint=hint)
    if array.dtype.kind == "M":
        seconds = array.astype("datetime64[ns]")
        return np.where(np.isnat(seconds), np.nan, seconds.astype(np.int64) / 1e9), True
    if array.dtype.kind == "m":
        return array / np.timedelta64(1, "s"), True
    if array.dtype.kind in "biuf":
        return _numbers(array, name), False
    texts = ["" if value is None else str(value) for value in array.tolist()]
    texts = ["" if text in ("nan", "NaT", "<NA>") else text for text in texts]
    try:
        return np.array([float(text) if text else np.nan for text in texts]), False
    except ValueError:
        return texts, False
