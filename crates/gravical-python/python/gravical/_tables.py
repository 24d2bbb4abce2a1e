"""Tables of other libraries, in and out. None of them has to be installed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ._errors import usage
from ._types import Floats


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
        raise usage("the table has no columns", "give columns for x, y and z of the accelerometer")
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
        raise usage(
            f"a {type(table).__name__} is read through Arrow, and pyarrow is not installed",
            "pip install pyarrow, or give a mapping from names to arrays",
        ) from None
    arrow = pyarrow.table(table)
    return [(name, arrow.column(name)) for name in arrow.column_names]


def _column(name: str, values: Any) -> tuple[Any, bool]:
    array = _array(values)
    if array.ndim != 1:
        raise usage(
            f"column {name!r} has the shape {array.shape}",
            "give one number for each row: an array with one axis",
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
        raise usage(
            f"{name}= is no array of numbers: {error}",
            "give an array of shape (n, 3), one row for each sample",
        ) from None
    if array.ndim != 2 or array.shape[1] != 3:
        turned = array.ndim == 2 and array.shape[0] == 3
        raise usage(
            f"{name}= has the shape {array.shape}; (n, 3) is needed",
            f"transpose it: {name}.T" if turned else "one row for each sample, x, y and z in it",
        )
    if rows is not None and len(array) != rows:
        raise usage(
            f"{name}= has {len(array)} samples, accel= has {rows}",
            "give one value of each for every sample, NaN where there is none",
            code="samples-length",
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
        raise usage(f"{name}= is no array of numbers: {error}") from None
    if array.ndim != 1 or len(array) != rows:
        raise usage(
            f"{name}= has the shape {array.shape}; ({rows},) is needed",
            "give one value for every sample, NaN where there is none",
            code="samples-length",
        )
    return array


class Columns:
    """Named columns that other libraries take as a data frame."""

    __slots__ = ()

    def _named(self) -> Mapping[str, Any]:
        raise NotImplementedError

    def to_pandas(self) -> Any:
        """All columns as a data frame of pandas."""
        return pandas_frame(self._named())

    def to_polars(self) -> Any:
        """All columns as a data frame of polars."""
        return polars_frame(self._named())

    def to_arrow(self) -> Any:
        """All columns as a table of Arrow, without copies where they lie in one piece; needs pyarrow."""
        return arrow_table(self._named())

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        """The Arrow PyCapsule interface; needs pyarrow."""
        return self.to_arrow().__arrow_c_stream__(requested_schema)


def pandas_frame(columns: Mapping[str, Any]) -> Any:
    """A data frame of pandas."""
    import pandas

    return pandas.DataFrame(dict(columns))


def polars_frame(columns: Mapping[str, Any]) -> Any:
    """A data frame of polars."""
    import polars

    return polars.DataFrame(dict(columns))


def arrow_table(columns: Mapping[str, Any]) -> Any:
    """A table of Arrow, which shares the memory of the arrays."""
    try:
        import pyarrow
    except ImportError:
        raise ImportError("Arrow tables need pyarrow: pip install pyarrow") from None
    return pyarrow.table({name: pyarrow.array(values) for name, values in columns.items()})


def replaced(
    table: Any, fields: Mapping[str, int], values: Mapping[str, Any], keep: bool
) -> Any:
    """The table with channels replaced in place, under new names; `values` are by channel, each
    with its name. With `keep` they are appended.
    """
    by_field = {} if keep else {fields[c]: v for c, v in values.items() if c in fields}
    new = [v for c, v in values.items() if keep or c not in fields]
    names, columns = _shown_columns(table)
    taken = {name for name, _ in values.values()}
    out: dict[str, Any] = {}
    for field, (name, column) in enumerate(zip(names, columns)):
        if field in by_field:
            name, column = by_field[field]
        elif name in taken:
            name = f"input_{name}"
        out[name] = column
    out.update(dict(new))
    if is_pandas(table):
        frame = pandas_frame({k: np.asarray(v) if k in taken else v for k, v in out.items()})
        frame.index = table.index
        return frame
    if hasattr(table, "get_columns"):
        return polars_frame(out)
    return out if isinstance(table, Mapping) else arrow_table(out)


def _shown_columns(table: Any) -> tuple[Sequence[str], Sequence[Any]]:
    if isinstance(table, Mapping):
        return [str(name) for name in table], list(table.values())
    if is_pandas(table):
        columns = [table.iloc[:, i].array for i in range(table.shape[1])]
        return [str(name) for name in table.columns], columns
    if hasattr(table, "get_columns"):
        return list(table.columns), table.get_columns()
    named = _through_arrow(table)
    return [name for name, _ in named], [column for _, column in named]
