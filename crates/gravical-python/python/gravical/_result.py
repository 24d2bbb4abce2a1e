"""Results: the JSON of the program as read-only dictionaries, with reports and figures."""

from __future__ import annotations

import json
import os
import warnings
from base64 import b64encode
from collections.abc import Mapping
from functools import partial
from html import escape
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from . import _gravical
from ._arguments import Floats, Path, is_path, keywords, vectors
from ._errors import UsageError

if TYPE_CHECKING:
    from typing_extensions import Self

    from . import _types


#: Methods of a dictionary that a record refuses.
_CHANGES = ("clear", "pop", "popitem", "setdefault", "update")


class Record(dict[str, Any]):
    """A dictionary that cannot be changed, with its items as attributes, too.

    >>> record = Record(verdict=Record(grade="good"))
    >>> record.verdict.grade, record["verdict"] == {"grade": "good"}
    ('good', True)
    """

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            here = ", ".join(self)
            raise AttributeError(f"there is no {name!r} here; there are {here}") from None

    def __dir__(self) -> list[str]:
        own = [name for name in super().__dir__() if name.startswith("__") or name[0] != "_"]
        return [name for name in own if name not in _CHANGES] + [*self]

    def _refuse(self, *_: Any, **__: Any) -> Any:
        """Refused: a result cannot be changed."""
        raise TypeError("a result cannot be changed; dict(result) makes a copy")

    __setitem__ = __delitem__ = __setattr__ = __delattr__ = __ior__ = _refuse  # pyright: ignore[reportAssignmentType]
    clear = pop = popitem = setdefault = update = _refuse  # pyright: ignore[reportAssignmentType]

    def __reduce__(self) -> tuple[Any, ...]:
        return Record, (dict(self),)


def parsed(text: str) -> Any:
    """JSON with records for objects."""
    return json.loads(text, object_hook=Record)


class Figure(NamedTuple):
    """A figure: its name, what it shows, and the SVG."""

    name: str
    title: str
    caption: str
    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write the figure as SVG. Nothing is overwritten without ``force``."""
        _gravical.write_text(path, self.svg, force)


class Result(Record):
    """What a command found: the JSON document of the program, same names, same numbers.

    ``str(result)`` is its report in short. Where the command writes a table, its columns are
    read-only arrays: of ``motion`` ``t`` (s), ``position`` (m), ``velocity`` (m/s),
    ``acceleration``, ``force`` and ``raw`` (m/s², shape (n, 3)), ``attitude`` (quaternion w, x, y,
    z, shape (n, 4)), ``sigma_position``, ``sigma_velocity``, ``sigma_tilt`` and
    ``sigma_heading`` (degrees; absent without bands) and ``still``; of ``orient`` those of the
    attitude, and ``roll_pitch_yaw`` (degrees, shape (n, 3)); of ``apply`` ``t``, ``accel`` and ``gyro``. ``denoise`` has ``recording``;
    ``simulate`` has ``recordings`` (by the names of their files) and ``paths``.

    Pickles keep document, arrays and summary; reports, figures and recordings are left behind.
    """

    def __init__(
        self, document: Mapping[str, Any], native: Any = None, table: Any = None, **others: Any
    ) -> None:
        super().__init__(document)
        arrays = {} if table is None else split(table[1], table[2])
        own = {"_native": native, "_table": table}
        vars(self).update({"_summary": "", **others, **arrays, **own})

    @classmethod
    def _of(cls, native: Any, groups: Groups = (), **others: Any) -> Self:
        table = native.table()
        if table is not None:
            names, values = table
            groups = groups if names[0] == "t_s" else groups[1:]
            table = (names, values.reshape(-1, len(names)), groups)
        return cls(parsed(native.json), native, table, **others)

    def _computed(self) -> Any:
        if self._native is None:
            hint = "reports and tables are written where it is computed"
            raise UsageError("this result holds its numbers alone", hint=hint)
        return self._native

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures of the report; none after a pickle."""
        return tuple(Figure(*drawn) for drawn in (self._native.figures() if self._native else ()))

    def report(self, path: Path | None = None, *, force: bool = False) -> str:
        """The report in full, as text; written to ``path``, too: ``.html`` is a page with everything in
        it, ``.txt`` text without figures."""
        ending = "txt" if path is None else os.path.splitext(os.fspath(path))[1].lower().lstrip(".")
        ending = "html" if ending == "htm" else ending
        if ending not in ("html", "txt"):
            hint = "name a file that ends in .html or .txt"
            message = f"a report is not written as {ending or 'a file without an ending'}"
            raise UsageError(message, "report-target", hint)
        text = str(self._computed().document(ending))
        if path is not None:
            _gravical.write_text(path, text, force)
        return text

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write what the program writes with ``-o``: the calibration, the table of a motion (CSV),
        else the document (JSON). Nothing is overwritten without ``force``."""
        text = json.dumps(self, indent=2, ensure_ascii=False) + "\n"
        self._computed().write(path, force, text)

    def export(
        self, to: str, output: Path | None = None, *, force: bool = False, **options: Any
    ) -> str:
        """A calibration (noise for ``"kalibr"`` and ``"ros-noise"``) as text in the format of another program, written
        to ``output``, too. It states what the target cannot hold, as warnings do
        (:class:`gravical.ExportWarning`); :func:`gravical.export_targets` says what each holds.

        Some targets have options, as of the program: ``name``, ``device_id``, ``counts_per_g``,
        ``counts_per_deg_s``, ``upper_limit``.
        """
        text, notes = self._computed().export(to, keywords(options))
        for note in notes:
            warnings.warn(note, ExportWarning, stacklevel=2)
        if output is not None:
            _gravical.write_text(output, text, force)
        return str(text)

    def plot(self, ax: Any = None) -> Any:
        """Draw the result on axes of matplotlib, and return them: of a motion the position with its 95 %
        band, of other tables their first vector; of a calibration the error of each pose left out."""
        if "poses" in self:
            errors = [pose.get("left_out_error_mps2") for pose in self["poses"]]
            known = [(i, e / G_MPS2 * 1e3) for i, e in enumerate(errors) if e is not None]
            if not known:
                raise UsageError("no pose was left out of six faces", hint="the errors of the poses are in ['poses']")
            ax = axes_of(ax)
            ax.bar([i for i, _ in known], [e for _, e in known])
            ax.set(xlabel="pose", ylabel="error of the pose left out (mg)")
            return ax
        if self._table is None:
            raise UsageError("this result has no rows", hint="its figures are in .figures")
        arrays = vars(self)
        vectors = (n for n in ("position", "roll_pitch_yaw", "accel", "velocity") if n in arrays)
        name = next(vectors, "attitude")
        values, ax = arrays[name], axes_of(ax)
        at = arrays.get("t", np.arange(len(values)))
        for axis, column in zip("xyz" if values.shape[1] == 3 else "wxyz", values.T):
            (line,) = ax.plot(at, column, label=axis, linewidth=0.8)
            if (band := arrays.get(f"sigma_{name}")) is not None:
                half = 1.96 * band[:, "xyz".index(axis)]
                ax.fill_between(at, column - half, column + half, color=line.get_color(), alpha=0.2)
        ax.set(xlabel="time (s)" if "t" in arrays else "row", ylabel=name.replace("_", " "))
        ax.legend()
        return ax

    def to_pandas(self) -> Any:
        """The columns as a data frame of pandas, with the names of the program's table."""
        import pandas

        if self._table is None:
            raise UsageError("this result has no rows", hint="its lists are in the document")
        names, values, _ = self._table
        frame = pandas.DataFrame(values, columns=names, copy=True)
        return frame.astype({"still": bool}) if "still" in names else frame

    def __str__(self) -> str:
        text = self._native.document("summary").rstrip() if self._native else self._summary
        # What the program shows with an option is shown by a method here.
        return str(text).replace("(--verbose)", "(report())") or repr(self)

    def _verdict(self) -> str:
        verdict = self.get("verdict") or {}
        return str(verdict.get("grade") or verdict.get("judgement") or "")

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._verdict() or ', '.join(list(self)[:4]) + ' …'}>"

    def _in_short(self) -> dict[str, Any]:
        """What a notebook shows."""
        plain = {k: v for k, v in self.items() if isinstance(v, (str, int, float))}
        if self._verdict():
            reasons = "; ".join(map(str, self["verdict"].get("reasons", ())))
            return {"verdict": f"{self._verdict()}: {reasons}", **plain}
        if "row_counts" in self:
            sensors = {
                name: self[name]["unit"] for name in ("accelerometer", "gyroscope") if self[name]
            }
            rate = (self["timing"] or {}).get("mean_rate_hz")
            return {**plain, "rate_hz": rate, **sensors, **_worded(self["findings"])}
        return plain

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>"
            for name, value in list(self._in_short().items())[:16]
            for text in [f"{value:.6g}" if isinstance(value, float) else str(value)]
        )
        # An image cannot disturb the page around it.
        image = "".join(
            f'<img alt="{escape(figure.title)}" '
            f'src="data:image/svg+xml;base64,{b64encode(figure.svg.encode()).decode()}">'
            for figure in self.figures[:1]
        )
        return f"<div><table>{rows}</table>{image}</div>"

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), table=self._table, _summary=str(self)), (dict(self),)


#: Standard gravity, m/s².
G_MPS2 = 9.80665


def _worded(findings: Any) -> dict[str, str]:
    """Findings by their kind."""
    return {finding["kind"]: finding["message"] for finding in findings}


def axes_of(ax: Any) -> Any:
    """These axes of matplotlib, or new ones."""
    if ax is not None:
        return ax
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        hint = "pip install matplotlib, or save one of .figures"
        raise UsageError("plot() needs matplotlib", hint=hint) from None
    return plt.figure().add_subplot()


#: Arrays of a table, each with the number of its columns, in their order.
Groups = tuple[tuple[str, int], ...]


def split(values: Floats, groups: Groups) -> dict[str, Any]:
    """Its columns as arrays by name, of shape (n,) or (n, width); what is 0 or 1 is true or false."""
    ends = np.cumsum([width for _, width in groups])[:-1]
    arrays = {
        name: part[:, 0] if width == 1 else part
        for (name, width), part in zip(groups, np.split(values, ends, axis=1))
        if part.shape[1]
    }
    return {k: v == 1 if k == "still" else v for k, v in arrays.items()}


class Calibration(Result):
    """A calibration of one sensor: calibrated = matrix · (raw − bias).

    Made by :func:`gravical.calibrate` or :meth:`load`. Its document is the file:
    ``calibration.accelerometer.bias``, ``.matrix``, ``.covariance``, ``calibration.gyroscope``,
    ``calibration.verdict.grade`` …
    """

    @property
    def document(self) -> _types.CalibrationDocument:
        """The same, with types for a checker: ``calibration.document["accelerometer"]["bias"]``."""
        return cast("_types.CalibrationDocument", self)

    @property
    def bias(self) -> Floats:
        """Bias of the accelerometer, in the unit of the raw values, shape (3,): a new array."""
        return np.array(self.accelerometer.bias)

    @property
    def matrix(self) -> Floats:
        """Its matrix, m/s² per unit of the raw values, shape (3, 3): a new array."""
        return np.array(self.accelerometer.matrix)

    def _in_short(self) -> dict[str, Any]:
        sensor, worst = self["accelerometer"], self["reliability"].get("worst_direction")
        deviations = sensor.get("deviations") or {}
        unit = sensor["input_unit"]
        error = {} if worst is None else {"error": f"{worst['error_mps2'] / G_MPS2 * 1e3:.2f} mg"}
        of = {f"bias ({unit})": "bias", "scale": "scale"}
        numbers = {
            f"{title} {axis}": f"{value:.6g}" + ("" if sd is None else f" ± {1.96 * sd:.2g}")
            for title, key in of.items()
            for axis, value, sd in zip("xyz", sensor[key], deviations.get(key) or [None] * 3)
        }
        reasons = "; ".join(self["verdict"].get("reasons", ()))
        return {"verdict": f"{self._verdict()}: {reasons}", **error, **numbers}

    @classmethod
    def load(cls, path: Path) -> Calibration:
        """Read a calibration file, of gravical or of imucal; ``calibration-syntax`` and others
        (:class:`gravical.InputError`) where it holds none."""
        return cls._of(_gravical.read_calibration(path, None))

    @classmethod
    def from_json(cls, text: str) -> Calibration:
        """The calibration in the text of a file, of gravical or of imucal."""
        return cls._of(_gravical.read_calibration(None, text))

    def apply(self, accel: Any) -> Floats:
        """Calibrated specific force, m/s², of raw readings in the unit of the calibration.

        Nothing is checked but the shape, (n, 3) or (3,). For a whole recording, with its unit,
        range and temperature checked, see :func:`gravical.apply`.

        >>> calibration.apply([[0.1, 0.2, 9.7]]).shape
        (1, 3)
        """
        raw = vectors(np.atleast_2d(accel), "accel")
        calibrated = _product(self.accelerometer.matrix, raw - self.accelerometer.bias)
        return calibrated[0] if np.ndim(accel) == 1 else calibrated

    def apply_gyro(self, gyro: Any, accel: Any = None) -> Floats:
        """Calibrated angular rate, rad/s, of raw readings; ``accel``, of the same shape, is the
        *calibrated* specific force, m/s², for the g-sensitivity. Without a gyroscope in the
        calibration :class:`gravical.UsageError`, ``gyro-not-calibrated``."""
        sensor = self.get("gyroscope")
        if sensor is None:
            hint = "calibrate with recordings that hold its columns"
            raise UsageError("the calibration has no gyroscope", "gyro-not-calibrated", hint)
        raw = vectors(np.atleast_2d(gyro), "gyro")
        rate = raw - sensor.bias
        if accel is not None:
            force = vectors(np.atleast_2d(accel), "accel")
            if len(force) != len(raw):
                message = f"accel= has {len(force)} samples, gyro= {len(raw)}"
                raise UsageError(message, "samples-length", "give one of each for every sample")
            rate = rate - _product(sensor.g_sensitivity, force)
        calibrated = _product(sensor.matrix, rate)
        return calibrated[0] if np.ndim(gyro) == 1 else calibrated

    def to_json(self) -> str:
        """The text of the file."""
        return self.export("gravical")

    def __hash__(self) -> int:  # type: ignore[override]
        return hash(self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        return Calibration.from_json, (self.to_json(),)


def _product(matrix: Any, rows: Floats) -> Floats:
    """The matrix times each row, in the order of the program: the same to the last bit."""
    x, y, z = rows.T
    with np.errstate(invalid="ignore", over="ignore"):
        return np.stack([a * x + b * y + c * z for a, b, c in matrix], axis=1)


class ExportWarning(UserWarning):
    """What a target of an export cannot hold."""


def calibration_of(given: Any) -> tuple[Any, str]:
    """The calibration and its name: a path is read."""
    if isinstance(given, Calibration):
        return given._computed(), "calibration"
    if is_path(given):
        return _gravical.read_calibration(given, None), os.fspath(given)
    if hasattr(given, "to_json") and type(given).__module__.startswith("imucal"):
        return _gravical.read_calibration(None, given.to_json()), "imucal"
    hint = "give a Calibration, the path of its file, or an object of imucal"
    raise UsageError(f"a {type(given).__name__} is no calibration", hint=hint)
