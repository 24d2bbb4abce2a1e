"""Tables of other libraries. None of them has to be installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ._errors import UsageError
from ._keywords import Floats


def is_table(value: Any) -> bool:
    """True for a data frame, a mapping of columns, or what Arrow can read."""
    return (
        isinstance(value, Mapping)
        or is_pandas(value)
        or hasattr(value, "get_columns")
        or hasattr(value, "__arrow_c_stream__")
    )


def is_pandas(value: Any) -> bool:
    """True for a data frame of pandas."""
    return hasattr(value, "iloc") and hasattr(value, "columns")


def table_columns(table: Any) -> tuple[list[str], list[Any], bool]:
    """Names and columns, each float64 without gaps or a list of texts; true if one held dates,
    which are seconds since 1970 now. A table whose names are 0, 1, 2 … has none.
    """
    if isinstance(table, Mapping):
        named = [(name, values) for name, values in table.items()]
    elif is_pandas(table):
        named = [(name, table.iloc[:, i]) for i, name in enumerate(table.columns)]
        if "datetime" in str(table.index.dtype):
            named.insert(0, (table.index.name or "time", table.index))
    elif hasattr(table, "get_columns"):
        named = [(column.name, column) for column in table.get_columns()]
    else:
        named = _through_arrow(table)
    if not named:
        raise UsageError(
            "the table has no columns", hint="give columns for x, y and z of the accelerometer"
        )
    columns: list[Any] = []
    dated = False
    for name, values in named:
        column, dates = _column(str(name), values)
        columns.append(column)
        dated |= dates
    numbered = all(isinstance(name, (int, np.integer)) for name, _ in named)
    return [] if numbered else [str(name) for name, _ in named], columns, dated


def _through_arrow(table: Any) -> list[tuple[str, Any]]:
    try:
        import pyarrow
    except ImportError:
        raise UsageError(
            f"a {type(table).__name__} is read through Arrow, and pyarrow is not installed",
            hint="pip install pyarrow, or give a mapping from names to arrays",
        ) from None
    arrow = pyarrow.table(table)
    return [(name, arrow.column(name)) for name in arrow.column_names]


def _column(name: str, values: Any) -> tuple[Any, bool]:
    array = _array(values)
    if array.ndim != 1:
        raise UsageError(
            f"column {name!r} has the shape {array.shape}",
            hint="give one number for each row: an array with one axis",
        )
    if array.dtype.kind == "M":
        seconds = array.astype("datetime64[ns]")
        empty = np.isnat(seconds)
        out = seconds.astype(np.int64) / 1e9
        out[empty] = np.nan
        return out, True
    if array.dtype.kind == "m":
        return array / np.timedelta64(1, "s"), True
    if array.dtype.kind in "biuf":
        return floats(array), False
    texts = ["" if _missing(v) else str(v) for v in array.tolist()]
    try:
        return np.array([float(t) if t else np.nan for t in texts]), False
    except ValueError:
        return texts, False


def _array(values: Any) -> np.ndarray[Any, Any]:
    dtype = str(getattr(values, "dtype", ""))
    if dtype.startswith(("Int", "UInt", "Float", "boolean")) and hasattr(values, "iloc"):
        # Pandas' own types with missing values.
        return np.asarray(values.to_numpy(dtype=np.float64, na_value=np.nan))
    if dtype.startswith("datetime64") and "," in dtype:
        # A zone: an index has tz_convert itself, a series below dt.
        dates = values.dt if hasattr(values, "dt") else values
        return np.asarray(dates.tz_convert(None))
    if hasattr(values, "to_numpy"):
        return np.asarray(values.to_numpy())
    return np.asarray(values)


def _missing(value: Any) -> bool:
    return value is None or str(value) in ("nan", "NaT", "<NA>")


def floats(values: Any) -> Floats:
    """The values as float64 without gaps; the same memory if they are that already."""
    return np.ascontiguousarray(values, dtype=np.float64)


def vectors(values: Any, name: str, rows: int | None = None) -> Floats:
    """Three columns: an array of shape (n, 3), or a tuple of three arrays."""
    try:
        if isinstance(values, tuple) and len(values) == 3 and np.ndim(values[0]) == 1:
            array = np.stack([np.asarray(v, dtype=np.float64) for v in values], axis=1)
        else:
            array = np.asarray(values)
            if array.dtype.kind not in "biuf":
                array = array.astype(np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(
            f"{name}= is no array of numbers: {error}",
            hint="give an array of shape (n, 3), one row for each sample",
        ) from None
    if array.ndim != 2 or array.shape[1] != 3:
        turned = array.ndim == 2 and array.shape[0] == 3
        raise UsageError(
            f"{name}= has the shape {array.shape}; (n, 3) is needed",
            hint=f"transpose it: {name}.T" if turned else "one row for each sample, x, y and z in it",
        )
    if rows is not None and len(array) != rows:
        raise UsageError(
            f"{name}= has {len(array)} samples, accel= has {rows}",
            "samples-length",
            "give one value of each for every sample, NaN where there is none",
        )
    return np.asarray(array, dtype=np.float64)


def scalars(values: Any, name: str, rows: int) -> Floats:
    """One number for each sample."""
    array = np.asarray(values)
    if array.dtype.kind in "Mm":
        return floats(_column(name, array)[0])
    try:
        array = floats(array)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{name}= is no array of numbers: {error}") from None
    if array.ndim != 1 or len(array) != rows:
        raise UsageError(
            f"{name}= has the shape {array.shape}; ({rows},) is needed",
            "samples-length",
            "give one value for every sample, NaN where there is none",
        )
    return array
