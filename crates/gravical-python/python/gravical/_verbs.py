"""The verbs of the program."""

from __future__ import annotations

import os
import tempfile
from typing import Any

from . import _gravical
from ._keywords import Path, keywords
from ._recording import Recording, native_source, read, session_of
from ._result import Calibration, Result, calibration_of, noise_of, parsed


def _with_source(source: Any, options: dict[str, Any]) -> tuple[Any, str]:
    native, extra = native_source(source)
    return native, keywords({**extra, **options})


def inspect(recording: Any, **options: Any) -> Result:
    """Show what is in a recording: columns, units, rate, defects, static intervals.

    Parameters
    ----------
    recording : path, recording or table
        As of :func:`gravical.read`.
    axes : str or sequence
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    **options
        How it is read: those of :func:`gravical.read`.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> len(gravical.inspect(line).static_intervals)
    2
    """
    return Result._of(_gravical.inspect(*_with_source(recording, options)))


def calibrate(session: Any, *, noise: Result | Path | None = None, **options: Any) -> Calibration:
    """Calibrate a sensor from recordings of static poses.

    Parameters
    ----------
    session : path, recording, table, or several of them
        The recordings of one session: files, a folder, :class:`Recording` objects, data frames, or
        one continuous recording in which the poses are found. A mapping from the name of a pose
        (``"+x"``, ``"-x"`` …) to a recording, table or array of shape (n, 3) names the poses.
    noise : result of :func:`gravical.noise`, or path of its file, optional
        Noise of the sensor, stored in the calibration.
    gravity : float
        Local gravity, m/s². By default 9.80665 ± 0.15 %.
    latitude, altitude : float
        Latitude in degrees and height in m, from which gravity is computed.
    method : str
        ``"joint"`` (the default: face and free poses in one fit that allows for tilted faces) or
        ``"ferraris"`` (six faces in closed form).
    pose_tilt : float
        Expected tilt of the face poses, degrees (standard deviation). By default estimated.
    prior : str
        Limits of the data sheet: ``"data-sheet"`` (the default) or ``"off"``.
    free_pose, face_pose : str or list of str
        Poses that are to be treated as free, or as faces.
    rows : int
        The first so many rows of each pose. By default its longest static interval.
    faces_from : str
        What decides which face was up: ``"data"`` (the default) or ``"names"``.
    turn_angle : float
        Signed angle of the turns about each axis, degrees. By default −360.
    axes : str or sequence
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    gyro : path
        Gyroscope of the one recording in a second file.
    sections : path
        Poses as ranges of rows: JSON of imucal, or CSV label,start,end.
    thermal : path or list of paths
        Recordings at rest while the sensor warms or cools, for a temperature model.
    sensor_id, sensor_model, recorded : str
        What is stored of the sensor and of the time of the session.
    **options
        How recordings are read: those of :func:`gravical.read`.

    Returns
    -------
    Calibration
        A result that cannot be trusted is no exception: its verdict is ``"poor"``.

    Raises
    ------
    InputError
        ``underdetermined``, ``missing-face``, ``never-static`` … : there is no result.
    UsageError
        ``option-range`` and others: an argument that is not possible.

    Examples
    --------
    >>> session = gravical.simulate("poses", free=8, seed=3)
    >>> calibration = gravical.calibrate(session.recordings, gravity=9.80665)
    >>> calibration.verdict.grade, len(calibration.accelerometer.bias)
    ('good', 3)
    """
    sources, given = session_of(session, options)
    return Calibration._of(_gravical.calibrate(sources, noise_of(noise), given))


def apply(
    calibration: Any,
    recording: Any,
    *,
    output: Path | None = None,
    force: bool = False,
    **options: Any,
) -> Result:
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
        have six decimals. Without it the channels are in memory, exact: ``t``, ``accel``, ``gyro``.
    force : bool
        Overwrite ``output``.
    keep_raw : bool
        Keep the raw columns of the file and append the calibrated ones.
    output_unit : str
        ``"m/s^2"`` (the default) or ``"g"``.
    axes : str or sequence
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    **options
        How it is read: those of :func:`gravical.read`.

    Raises
    ------
    InputError
        ``unit-mismatch``: the calibration is for another unit, range or sensor.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> applied = gravical.apply(calibration, line)
    >>> applied.accel.shape, applied.columns[:3]
    ((1200, 3), ['ax_mps2', 'ay_mps2', 'az_mps2'])
    """
    native, _ = calibration_of(calibration)
    source, given = _with_source(recording, options)
    return Result._of(_gravical.apply(native, source, output, force, given))


def denoise(
    recording: Any,
    filter: Any,
    *,
    output: Path | None = None,
    force: bool = False,
    **options: Any,
) -> Result:
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
        Without it the filtered recording is ``recording`` of the result.
    force : bool
        Overwrite ``output``.
    channels : str
        ``"all"`` (the default), ``"accel"`` or ``"gyro"``.
    **options
        How it is read: those of :func:`gravical.read`.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> smooth = gravical.denoise(line, "butter:4,5Hz").recording
    >>> bool(smooth.ax.std() < line.ax.std())
    True
    """
    source, given = _with_source(recording, {"filter": filter, **options})
    filtered, outcome = _gravical.denoise(source, output, force, given)
    rows = None if filtered is None else Recording(filtered)
    return Result._of(outcome, recording=rows)


def noise(recording: Any, **options: Any) -> Result:
    """Determine the noise of a sensor from a recording at rest (Allan deviation).

    Parameters
    ----------
    recording : path, recording or table
        Of a sensor that lies still; what moves is left out.
    spacing : str
        Averaging times: ``"octave"`` (the default), ``"dense"`` or ``"decade"``.
    part : str
        Part whose data sheet it is compared with: ``"MPU6050"`` …
    **options
        How it is read: those of :func:`gravical.read`.

    Raises
    ------
    InputError
        ``not-at-rest``: the sensor never lies still for ten seconds.

    Examples
    --------
    >>> rest = gravical.simulate("static", duration=60).recordings["static.csv"]
    >>> n = gravical.noise(rest).channels[0].n
    >>> n.low < n.value < n.high
    True
    """
    return Result._of(_gravical.noise(*_with_source(recording, options)))


def check(calibration: Any, session: Any, **options: Any) -> Result:
    """Test whether a calibration still fits new recordings at rest.

    Parameters
    ----------
    calibration : Calibration, path, or object of imucal
        What is tested.
    session : path, recording, table, or several of them
        One static interval in any pose is enough.
    gravity, latitude, altitude : float
        Local gravity, by default that of the calibration.
    gyro : path
        Gyroscope of the one recording in a second file.
    axes : str or sequence
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    **options
        How recordings are read: those of :func:`gravical.read`.

    Returns
    -------
    Result
        ``verdict.judgement`` is ``"fits"``, ``"does-not-fit"`` or ``"undecided"``.
    """
    native, name = calibration_of(calibration)
    return Result._of(_gravical.check(native, name, *session_of(session, options)))


def compare(first: Any, second: Any) -> Result:
    """Test whether two calibrations differ by more than their uncertainty.

    Parameters
    ----------
    first, second : Calibration, path, or object of imucal
        What is compared.

    Returns
    -------
    Result
        ``verdict.judgement`` is ``"agree"``, ``"differ"`` or ``"undecided"``.
    """
    (a, name_a), (b, name_b) = calibration_of(first), calibration_of(second)
    if name_a == name_b:
        name_a, name_b = f"first {name_a}", f"second {name_b}"
    return Result._of(_gravical.compare(a, b, [name_a, name_b]))


def simulate(
    scenario: str, *, output: Path | None = None, force: bool = False, **options: Any
) -> Result:
    """Simulate recordings of an MPU6050 with known true errors.

    Parameters
    ----------
    scenario : str
        ``"six-position"``, ``"poses"``, ``"static"`` or ``"line"``.
    output : path, optional
        Folder to write to, as the program. Without it nothing is left on the disk.
    force : bool
        Overwrite existing files.
    **options
        The options of ``gravical simulate SCENARIO --help`` with their names: ``seed``, ``free``,
        ``rate`` (Hz), ``tilt`` (°), ``duration`` (s), ``distance`` (m), ``raw`` …

    Returns
    -------
    Result
        The truth: ``truth.json`` of the program; ``recordings`` by the names of their files.

    Raises
    ------
    UsageError
        ``simulate-option`` for a value out of its range.

    Examples
    --------
    >>> simulated = gravical.simulate("poses", free=8, seed=3)
    >>> simulated.recordings["poses.csv"].rate_hz, len(simulated.accelerometer.bias_mps2)
    (100.0, 3)
    """
    if output is not None:
        return _simulated(scenario, output, force, keywords(options))
    with tempfile.TemporaryDirectory(prefix="gravical-") as folder:
        return _simulated(scenario, folder, False, keywords(options), keep=False)


def _simulated(scenario: str, folder: Path, force: bool, given: str, keep: bool = True) -> Result:
    truth, paths = _gravical.simulate(str(scenario), folder, force, given)
    recordings: dict[str, Recording] = {}
    for path in map(str, paths[:-1]):
        name = os.path.basename(path)
        with open(path, "rb") as file:
            recordings[name] = read(file.read(), name=name)
    kept = [str(path) for path in paths] if keep else []
    summary = f"simulated: {', '.join(recordings)}"
    return Result(parsed(truth), None, summary, recordings=recordings, paths=kept)


def export_targets() -> dict[str, str]:
    """The targets of :meth:`Result.export`, each with what it holds."""
    return dict(_gravical.export_targets())
