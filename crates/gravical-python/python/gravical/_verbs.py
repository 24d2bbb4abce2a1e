"""The verbs of the program that are no class of their own."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _gravical, _tables
from ._calibration import Calibration, calibration_of
from ._errors import usage
from ._findings import Finding
from ._recording import Recording, Source, path_of, read, session_of
from ._results import (
    ApplySummary,
    CheckReport,
    Comparison,
    Inspection,
    NoiseResult,
    Result,
)
from ._types import Floats, Path, Reading, options

if TYPE_CHECKING:
    from typing_extensions import TypeGuard, Unpack


def _is_path(source: Any) -> TypeGuard[Path]:
    return isinstance(source, (str, os.PathLike))


def _needs_file(name: str, source: Any) -> Path:
    if _is_path(source):
        return path_of(source)
    raise usage(
        f"{name}= goes from file to file, and the recording is in memory",
        f"give the path of the recording, or leave out {name}=",
    )


def inspect(
    recording: Source,
    *,
    gyro: Path | None = None,
    axes: str | Sequence[str] | None = None,
    **reading: Unpack[Reading],
) -> Inspection:
    """Show what is in a recording: columns, units, rate, defects, static intervals.

    Parameters
    ----------
    recording : path, recording or table
        A file of any size is read in constant memory.
    gyro : path, optional
        Gyroscope of the recording in a second file.
    axes : str or sequence, optional
        Sensor axes that point along x, y and z of the case.
    **reading
        How it is read: see :class:`Reading`.

    Returns
    -------
    Inspection
        ``str()`` of it is the report; ``to_dict()`` the document of ``gravical inspect --json``.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> len(gravical.inspect(line).to_dict()["static_intervals"])
    2
    """
    if _is_path(recording):
        given = options(reading, axes=axes)
        return Inspection(_gravical.inspect_path(recording, gyro, given))
    rows = read(recording, gyro=gyro, **reading)
    return Inspection(_gravical.inspect_recording(rows._native, options({}, axes=axes)))


class Applied(ApplySummary, _tables.Columns):
    """A calibrated recording in memory: :func:`gravical.apply`.

    Attributes
    ----------
    t : array of shape (n,) or None
        Seconds since the first row.
    accel : array of shape (n, 3)
        Calibrated specific force, m/s² (or g, with ``output_unit="g"``).
    gyro : array of shape (n, 3) or None
        Calibrated angular rate, rad/s.
    columns : dict
        The same by the names of the program: ``ax_mps2`` … ``gz_rad_s``.
    table : table or None
        Where a table was given: one of the same kind, with the calibrated channels in place of the
        raw ones (beside them with ``keep_raw``) and all other columns as they were.
    """

    def __init__(
        self,
        document: dict[str, Any],
        t: Floats | None,
        columns: dict[str, Floats],
        table: Any,
    ) -> None:
        super().__init__(document)
        self.t = t
        self.columns = columns
        self.table = table

    @property
    def accel(self) -> Floats:
        """Calibrated specific force, shape (n, 3)."""
        return np.stack(list(self.columns.values())[:3], axis=1)

    @property
    def gyro(self) -> Floats | None:
        """Calibrated angular rate, rad/s, shape (n, 3); None without a gyroscope."""
        rates = list(self.columns.values())[3:]
        return np.stack(rates, axis=1) if rates else None

    def _named(self) -> dict[str, Floats]:
        return self.columns if self.t is None else {"t_s": self.t, **self.columns}


def apply(
    calibration: Calibration | Path,
    recording: Source,
    *,
    output: Path | None = None,
    force: bool = False,
    gyro: Path | None = None,
    keep_raw: bool = False,
    output_unit: Literal["m/s^2", "g"] | None = None,
    axes: str | Sequence[str] | None = None,
    **reading: Unpack[Reading],
) -> Any:
    """Apply a calibration to a recording.

    Parameters
    ----------
    calibration : Calibration, path, or object of imucal
        What is applied.
    recording : path, recording or table
        Unit and range are checked against the calibration, and drift with temperature is
        subtracted.
    output : path, optional
        From file to file, in constant memory, as the program: all other columns are copied, values
        have six decimals. Without it the result is in memory, exact.
    force : bool
        Overwrite ``output``.
    gyro : path, optional
        Gyroscope of the recording in a second file.
    keep_raw : bool
        Keep the raw columns of a file or table and append the calibrated ones.
    output_unit : str, optional
        ``"m/s^2"`` (the default) or ``"g"``.
    axes : str or sequence, optional
        Sensor axes that point along x, y and z of the case.
    **reading
        How it is read: see :class:`Reading`.

    Returns
    -------
    Applied, or ApplySummary with ``output``

    Raises
    ------
    InputError
        ``unit-mismatch``: the calibration is for another unit, range or sensor.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> applied = gravical.apply(calibration, line)
    >>> applied.accel.shape, list(applied.columns)[:3]
    ((1200, 3), ['ax_mps2', 'ay_mps2', 'az_mps2'])
    """
    native, _ = calibration_of(calibration)
    given = options(
        reading, keep_raw=keep_raw, output_unit=output_unit, axes=axes
    )
    if output is not None:
        path = _needs_file("output", recording)
        summary = _gravical.apply_file(native, path, output, gyro, force, given)
        return ApplySummary(json.loads(summary))
    rows = read(recording, gyro=gyro, **reading)
    accel, rates, summary = _gravical.apply_recording(native, rows._native, given)
    document = json.loads(summary)
    columns: dict[str, Floats] = dict(zip(document["columns"], [*accel, *(rates or [])]))
    table = None
    keep = given.get("keep_raw", False)
    if not isinstance(recording, Recording) and _tables.is_table(recording):
        names, raw, _ = _tables.table_columns(recording)
        fields = _gravical.Recording.table_fields("table", names, raw, options(reading))
        channels = ("ax", "ay", "az", "gx", "gy", "gz")
        values: dict[str, Any] = dict(zip(channels, columns.items()))
        table = _tables.replaced(recording, fields, values, bool(keep))
    return Applied(document, rows.t, columns, table)


class Denoised(Result):
    """A filtered recording: :func:`gravical.denoise`.

    Attributes
    ----------
    recording : Recording or None
        The recording with filtered channels; None if it went from file to file.
    """

    recording: Recording | None = None

    @property
    def filters(self) -> list[dict[str, Any]]:
        """Each filter with its response and its effect on the noise."""
        return list(self._dict["filters"])


def denoise(
    recording: Source,
    filter: str | Sequence[str],
    *,
    output: Path | None = None,
    force: bool = False,
    channels: Literal["accel", "gyro", "all"] | None = None,
    **reading: Unpack[Reading],
) -> Denoised:
    """Filter a recording and report the effect on its noise.

    Parameters
    ----------
    recording : path, recording or table
        Breaks, gaps, uneven time stamps and empty cells are respected.
    filter : str or list of str
        ``"savgol:WINDOW,ORDER"``, ``"butter:ORDER,CUTOFFHz"``, ``"highpass:…"``,
        ``"hampel:WINDOW,SIGMAS"``, ``"mean:WINDOW"`` …, in this order.
    output : path, optional
        From file to file, as the program: other columns are copied, values have six decimals.
    force : bool
        Overwrite ``output``.
    channels : str, optional
        ``"all"`` (the default), ``"accel"`` or ``"gyro"``.
    **reading
        How it is read: see :class:`Reading`.

    Returns
    -------
    Denoised

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> smooth = gravical.denoise(line, "butter:4,5Hz")
    >>> bool(smooth.recording.ax.std() < line.ax.std())
    True
    """
    given = options(reading, filter=filter, channels=channels)
    if output is not None:
        path = _needs_file("output", recording)
        return Denoised(_gravical.denoise_file(path, output, force, given))
    rows = read(recording, **reading)
    own = options({}, filter=filter, channels=channels)
    filtered, outcome = _gravical.denoise_recording(rows._native, own)
    done = Denoised(outcome)
    done.recording = Recording(filtered)
    return done


def noise(
    recording: Source,
    *,
    spacing: Literal["octave", "dense", "decade"] | None = None,
    part: str | None = None,
    **reading: Unpack[Reading],
) -> NoiseResult:
    """Determine the noise of a sensor from a recording at rest (Allan deviation).

    Parameters
    ----------
    recording : path, recording or table
        Of a sensor that lies still; what moves is left out.
    spacing : str, optional
        Averaging times: ``"octave"`` (the default), ``"dense"`` or ``"decade"``.
    part : str, optional
        Part whose data sheet it is compared with: ``"MPU6050"`` …
    **reading
        How it is read: see :class:`Reading`.

    Returns
    -------
    NoiseResult

    Raises
    ------
    InputError
        ``not-at-rest``: the sensor never lies still for ten seconds.

    Examples
    --------
    >>> rest = gravical.simulate("static", duration=60).recordings["static.csv"]
    >>> n = gravical.noise(rest).channels["ax"]["n"]
    >>> n["low"] < n["value"] < n["high"]
    True
    """
    own = {"spacing": spacing, "part": part}
    if _is_path(recording):
        return NoiseResult(_gravical.noise_path(recording, options(reading, **own)))
    rows = read(recording, **reading)
    return NoiseResult(_gravical.noise_recording(rows._native, options({}, **own)))


def check(
    calibration: Calibration | Path,
    session: Source | Sequence[Source],
    *,
    gravity: float | None = None,
    latitude: float | None = None,
    altitude: float | None = None,
    gyro: Path | None = None,
    axes: str | Sequence[str] | None = None,
    **reading: Unpack[Reading],
) -> CheckReport:
    """Test whether a calibration still fits new recordings at rest.

    Parameters
    ----------
    calibration : Calibration, path, or object of imucal
        What is tested.
    session : path, recording, table, or several of them
        One static interval in any pose is enough.
    gravity, latitude, altitude : float, optional
        Local gravity, by default that of the calibration.
    gyro : path, optional
        Gyroscope of the recording in a second file.
    axes : str or sequence, optional
        Sensor axes that point along x, y and z of the case.
    **reading
        How it is read: see :class:`Reading`.

    Returns
    -------
    CheckReport
        Its verdict is ``"fits"``, ``"does-not-fit"`` or ``"undecided"``.
    """
    native, name = calibration_of(calibration)
    given = options(reading, gravity=gravity, latitude=latitude, altitude=altitude, axes=axes)
    paths, recordings = session_of(session, reading)
    if paths is not None:
        return CheckReport(_gravical.check_paths(native, name, paths, gyro, given))
    if gyro is not None:
        raise usage("gyro= joins two files", "read both first: gravical.read(path, gyro=path)")
    return CheckReport(_gravical.check_recordings(native, name, recordings or [], given))


def compare(first: Calibration | Path, second: Calibration | Path) -> Comparison:
    """Test whether two calibrations of a sensor differ by more than their uncertainty.

    Parameters
    ----------
    first, second : Calibration, path, or object of imucal
        Differences are second − first.

    Returns
    -------
    Comparison
        Its verdict is ``"agree"``, ``"differ"`` or ``"undecided"``.
    """
    (a, name_a), (b, name_b) = calibration_of(first), calibration_of(second)
    if name_a == name_b:
        name_a, name_b = f"first {name_a}", f"second {name_b}"
    return Comparison(_gravical.compare(a, b, [name_a, name_b]))


class Simulation:
    """Simulated recordings and their true values: :func:`gravical.simulate`.

    Attributes
    ----------
    recordings : dict
        The recordings by the names of their files.
    truth : dict
        The true parameters, poses and moves: ``truth.json`` of the program.
    paths : list of str
        The files, if they were written; the truth last.
    """

    def __init__(
        self, recordings: dict[str, Recording], truth: dict[str, Any], paths: list[str]
    ) -> None:
        self.recordings = recordings
        self.truth = truth
        self.paths = paths

    def __repr__(self) -> str:
        return f"<Simulation: {', '.join(self.recordings)}>"

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is odd in the recordings."""
        return tuple(f for r in self.recordings.values() for f in r.findings)


def simulate(
    scenario: Literal["six-position", "poses", "static", "line"],
    *,
    output: Path | None = None,
    force: bool = False,
    **simulated: Any,
) -> Simulation:
    """Simulate recordings of an MPU6050 with known true errors.

    Parameters
    ----------
    scenario : str
        ``"six-position"``, ``"poses"``, ``"static"`` or ``"line"``.
    output : path, optional
        Folder to write to, as the program. Without it nothing is left on the disk.
    force : bool
        Overwrite existing files.
    **simulated
        The options of ``gravical simulate SCENARIO --help`` with their names: ``seed``, ``free``,
        ``rate``, ``tilt``, ``duration``, ``distance``, ``raw`` …

    Returns
    -------
    Simulation

    Raises
    ------
    UsageError
        ``simulate-option`` for a value out of its range.

    Examples
    --------
    >>> gravical.simulate("poses", free=8, seed=3)
    <Simulation: poses.csv>
    """
    if not isinstance(scenario, str) or scenario not in _SCENARIOS:
        raise usage(f"{scenario!r} is no scenario", f"one of {', '.join(_SCENARIOS)}")
    known = _SCENARIOS[scenario] | _SHARED
    unknown = sorted(set(simulated) - known)
    if unknown:
        raise TypeError(
            f"unexpected keyword argument {unknown[0]!r}; {scenario} takes "
            + ", ".join(sorted(known))
        )
    given = options({}, **simulated)
    if output is not None:
        return _simulated(scenario, output, force, given)
    with tempfile.TemporaryDirectory(prefix="gravical-") as folder:
        made = _simulated(scenario, folder, False, given)
    made.paths = []
    return made


def _simulated(scenario: str, folder: Path, force: bool, given: Mapping[str, Any]) -> Simulation:
    truth, paths = _gravical.simulate(scenario, folder, force, given)
    recordings: dict[str, Recording] = {}
    for path in map(str, paths[:-1]):
        name = os.path.basename(path)
        with open(path, "rb") as file:
            recordings[name] = read(file.read(), name=name)
    return Simulation(recordings, json.loads(truth), [str(path) for path in paths])


_SHARED = frozenset(
    """
    seed gravity tilt rate jitter drop wrong_header raw decimals range noise scale_sd
    temperature_rise temperature_drift
    """.split()
)
_SCENARIOS = {
    "six-position": frozenset({"hold", "continuous", "rest", "turn_angle"}),
    "poses": frozenset({"hold", "free"}),
    "static": frozenset({"duration", "soak", "gyro_drift"}),
    "line": frozenset({"distance", "move_time", "rest"}),
}
