"""The verbs of the program."""

from __future__ import annotations

import os
import tempfile
from typing import Any

from . import _gravical
from ._arguments import Path, keywords
from ._recording import Recording, read, session_of
from ._result import Calibration, Groups, Result, calibration_of, noise_of, parsed

#: The arrays of a motion.
_MOTION: Groups = (
    ("t", 1), ("raw", 3), ("force", 3), ("still", 1), ("attitude", 4), ("acceleration", 3),
    ("velocity", 3), ("position", 3), ("sigma_velocity", 3), ("sigma_position", 3),
)  # fmt: skip


def _run(
    verb: str,
    session: Any,
    options: dict[str, Any],
    *calibrations: Any,
    noise: Any = None,
    output: Path | None = None,
    force: bool = False,
) -> Any:
    sources, options = session_of(session, options)
    target = None if output is None else (output, force)
    named = [calibration_of(calibration) for calibration in calibrations]
    return _gravical.run(verb, sources, named, noise_of(noise), target, keywords(options))


def inspect(recording: Any, **options: Any) -> Result:
    """Show what is in a recording, as of :func:`gravical.read`: columns, units, rate, defects, rests.

    Its keywords are ``axes``, as of :func:`gravical.calibrate`, and those of :func:`gravical.read`.
    """
    return Result._of(_run("inspect", recording, options))


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
    **options
        - ``gravity``, m/s², or ``latitude``, °, and ``altitude``, m; by default 9.80665 ± 0.15 %.
        - ``method``: ``"joint"`` (face and free poses in one fit that allows for tilted faces) or
          ``"ferraris"`` (six faces in closed form).
        - ``pose_tilt``: expected tilt of the faces, ° (standard deviation); by default estimated.
        - ``prior``: limits of the data sheet: ``"data-sheet"`` or ``"off"``.
        - ``free_pose``, ``face_pose``: names of poses to be treated as free, or as faces.
        - ``axes``: the sensor's axes that point along x, y and z of the case: ``"y,-x,z"``.
        - ``gyro``: path of the gyroscope of the one recording.
        - ``sections``: path of the poses as ranges of rows: JSON of imucal, or CSV label,start,end.
        - ``thermal``: paths of recordings at rest while the sensor warms or cools.
        - ``sensor_id``, ``sensor_model``, ``recorded``: what is stored of sensor and time.
        - How recordings are read: those of :func:`gravical.read`.

    Returns
    -------
    Calibration
        A result that cannot be trusted is no exception: its verdict is ``"poor"``. Without any,
        :class:`gravical.InputError`: ``underdetermined``, ``missing-face``, ``never-static`` …

    Examples
    --------
    >>> session = gravical.simulate("poses", free=8, seed=3)
    >>> calibration = gravical.calibrate(session.recordings, gravity=9.80665)
    >>> calibration.verdict.grade, len(calibration.accelerometer.bias)
    ('good', 3)
    """
    return Calibration._of(_run("calibrate", session, options, noise=noise))


def apply(
    calibration: Any,
    recording: Any,
    *,
    output: Path | None = None,
    force: bool = False,
    **options: Any,
) -> Result:
    """Apply a calibration to a recording, whose unit and range are checked (``unit-mismatch``).

    Parameters
    ----------
    calibration, recording
        What is applied: a Calibration, path, or object of imucal; to a path, recording or table.
    output, force : path, bool
        From file to file, in constant memory, as the program: all other columns are copied, values
        have six decimals; ``force`` overwrites. Without it the channels are in memory, exact: ``t``,
        ``accel``, ``gyro``.
    **options
        ``output_unit``: ``"m/s^2"`` (the default) or ``"g"``; ``keep_raw``: keep the raw columns of
        the file; ``axes`` as of :func:`gravical.calibrate`, and those of :func:`gravical.read`.
    """
    done = _run("apply", recording, options, calibration, output=output, force=force)
    return Result._of(done, (("t", 1), ("accel", 3), ("gyro", 3)))


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
        Breaks, gaps and empty cells are respected; uneven time stamps are refused
        (``uneven-stamps``).
    filter : str or list of str
        ``"savgol:WINDOW,ORDER"``, ``"butter:ORDER,CUTOFFHz"``, ``"highpass:…"``,
        ``"hampel:WINDOW,SIGMAS"``, ``"mean:WINDOW"`` …, in this order.
    output, force : path, bool
        As of :func:`gravical.apply`. In memory it is ``recording`` of the result.
    **options
        Those of :func:`gravical.read`.
    """
    options["filter"] = filter
    done = _run("denoise", recording, options, output=output, force=force)
    rows = done.recording()
    return Result._of(done, recording=None if rows is None else Recording(rows))


def noise(recording: Any, **options: Any) -> Result:
    """Determine the noise of a sensor from a recording at rest (Allan deviation).

    Parameters
    ----------
    recording : path, recording or table
        Of a sensor that lies still for ten seconds (else ``not-at-rest``); what moves is left out.
    **options
        Those of :func:`gravical.read`.
    """
    return Result._of(_run("noise", recording, options))


def check(calibration: Any, session: Any, **options: Any) -> Result:
    """Test whether a calibration still fits new recordings at rest, of which one in any pose is enough.

    Its keywords are ``gravity``, ``latitude``, ``altitude`` (by default that of the calibration),
    ``gyro`` and ``axes``, as of :func:`gravical.calibrate`, and those of :func:`gravical.read`.
    ``verdict.judgement`` is ``"fits"``, ``"does-not-fit"`` or ``"undecided"``.
    """
    return Result._of(_run("check", session, options, calibration))


def compare(first: Any, second: Any) -> Result:
    """Test whether two calibrations, paths of them, or objects of imucal differ by more than their
    uncertainty: ``verdict.judgement`` is ``"agree"``, ``"differ"`` or ``"undecided"``."""
    (a, name_a), (b, name_b) = calibration_of(first), calibration_of(second)
    if name_a == name_b:
        name_a, name_b = f"first {name_a}", f"second {name_b}"
    pair = [(a, name_a), (b, name_b)]
    return Result._of(_gravical.run("compare", [], pair, None, None, keywords({})))


def motion(recording: Any, calibration: Any = None, **options: Any) -> Result:
    """Compute velocity and position with error bands.

    Parameters
    ----------
    recording : path, recording or table
        With rests of some seconds before and after each move.
    calibration : Calibration, path, or object of imucal, optional
        Without it the nominal scales are used.
    **options
        - ``truth``: path of reference positions to compare with: t_s, px_m, py_m, pz_m.
        - ``procedure``: ``"strapdown"``, ``"constant-tilt"``, or ``"report"`` for that of the student report.
        - ``causal``: use the past only.
        - ``rests``, s: ``"0-5,7.2-"`` or ``[(0, 5), (7.2, None)]``; by default found.
        - ``no_stances``: take no moment between swings for a foot in stance.
        - ``gravity``, ``latitude``, ``altitude`` (by default that of the calibration) and ``axes``
          as of :func:`gravical.calibrate`, and those of :func:`gravical.read`.

    Returns
    -------
    Result
        With the arrays of :class:`Result`. ``verdict.judgement`` is ``"bounded"``, ``"partly-open"``,
        ``"open"``, ``"at-rest"`` or ``"not-usable"``.
    """
    given = () if calibration is None else (calibration,)
    return Result._of(_run("motion", recording, options, *given), _MOTION)


def simulate(
    scenario: str, *, output: Path | None = None, force: bool = False, **options: Any
) -> Result:
    """Simulate recordings of an MPU6050 with known true errors.

    Parameters
    ----------
    scenario : str
        ``"six-position"``, ``"poses"``, ``"static"`` or ``"line"``.
    output, force : path, bool
        Folder to write to, as the program. Without it nothing is left on the disk.
    **options
        As of ``gravical simulate SCENARIO --help``: ``seed``, ``free``, ``rate`` (Hz), ``tilt`` (°),
        ``duration`` (s), ``distance`` (m), ``raw`` …

    The result is the truth, ``truth.json`` of the program; ``recordings`` has the names of the files.
    """
    with tempfile.TemporaryDirectory(prefix="gravical-") as folder:
        target = folder if output is None else output
        truth, paths = _gravical.simulate(str(scenario), target, force, keywords(options))
        recordings: dict[str, Recording] = {}
        for path in map(str, paths[:-1]):
            name = os.path.basename(path)
            with open(path, "rb") as file:
                recordings[name] = read(file.read(), name=name)
    kept = [] if output is None else [str(path) for path in paths]
    summary = f"simulated: {', '.join(recordings)}"
    return Result(parsed(truth), recordings=recordings, paths=kept, _summary=summary)


def export_targets() -> dict[str, str]:
    """The targets of :meth:`Result.export`, each with what it holds."""
    return dict(_gravical.export_targets())
