"""gravical: turn a cheap IMU into an instrument you can trust.

The functions are the commands of the program, their keywords its options (``--pose-tilt`` is
``pose_tilt=``), and results its JSON, number by number.

>>> import gravical
>>> session = gravical.simulate("poses", free=8, seed=3)
>>> calibration = gravical.calibrate(session.recordings, gravity=9.80665)
>>> calibration.verdict.grade
'good'

Errors are exceptions (:class:`Error`) with a ``code`` and a ``hint``; what is odd but no error is
in the ``findings`` of a result.
"""

from __future__ import annotations

import os
import tempfile
from typing import TYPE_CHECKING, Any

from . import _gravical
from ._arguments import Path, keywords
from ._errors import Error, ExistsError, InputError, MachineError, NotFoundError, UsageError
from ._gravical import __version__
from ._recording import Recording, read, session_of
from ._result import Calibration, ExportWarning, Figure, Groups, Record, Result
from ._result import calibration_of, parsed

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from . import _types

__all__ = [
    "Calibration", "Error", "ExistsError", "ExportWarning", "Figure", "InputError", "MachineError",
    "NotFoundError", "Record", "Recording", "Result", "UsageError", "__version__",
    "apply", "calibrate", "check", "compare", "denoise", "export_targets", "inspect", "motion",
    "noise", "orient", "read", "simulate",
]  # fmt: skip

#: The arrays of a motion.
_MOTION: Groups = (
    ("t", 1), ("raw", 3), ("force", 3), ("still", 1), ("attitude", 4), ("acceleration", 3),
    ("velocity", 3), ("position", 3), ("sigma_velocity", 3), ("sigma_position", 3),
    ("sigma_tilt", 1), ("sigma_heading", 1),
)  # fmt: skip

#: Those of an orientation.
_ORIENTATION: Groups = (
    ("t", 1), ("still", 1), ("attitude", 4), ("roll_pitch_yaw", 3), ("sigma_tilt", 1),
    ("sigma_heading", 1), ("acceleration", 3),
)  # fmt: skip


def _run(
    verb: str,
    session: Any,
    options: Any,
    *calibrations: Any,
    target: tuple[Path, bool] | None = None,
) -> Any:
    sources, options = session_of(session, options)
    named = [calibration_of(calibration) for calibration in calibrations]
    return _gravical.run(verb, sources, named, target, keywords(options))


def inspect(recording: Any, **options: Unpack[_types.InspectOptions]) -> Result:
    """Show what is in a recording: columns, units, rate, defects, rests. Its keywords are ``axes``, as
    of :func:`gravical.calibrate`, and those of :func:`gravical.read`."""
    return Result._of(_run("inspect", recording, options))


def calibrate(session: Any, **options: Unpack[_types.CalibrateOptions]) -> Calibration:
    """Calibrate a sensor from recordings of static poses. A result that cannot be trusted is no
    exception: its verdict is ``"poor"``.

    - ``session``: the recordings of one session: files, a folder, :class:`Recording` objects, data
      frames, arrays of shape (n, 3), or (n, 6) with a gyroscope, and their ``rate``; or one continuous recording in which the poses are found. A mapping from the name of a
      pose (``"+x"``, ``"-x"`` …) to a recording, table or array of shape (n, 3) names the poses.
    - ``gravity``, m/s², or ``latitude``, °, and ``altitude``, m; by default 9.80665 ± 0.15 %.
    - ``method``: ``"joint"`` (face and free poses in one fit that allows for tilted faces) or
      ``"ferraris"`` (six faces in closed form).
    - ``pose_tilt``: expected tilt of the faces, ° (standard deviation); by default estimated.
    - ``prior``: limits of the data sheet: ``"data-sheet"`` or ``"off"``.
    - ``free_pose``, ``face_pose``: names of poses to be treated as free, or as faces.
    - ``axes``: the sensor's axes that point along x, y and z of the case: ``"y,-x,z"``.
    - ``sections``: path of the poses as ranges of rows: JSON of imucal, or CSV label,start,end.
    - ``thermal``: paths of recordings at rest while the sensor warms or cools.
    - ``sensor_id``, ``sensor_model``, ``recorded``: what is stored of sensor and time.
    - The keywords of :func:`gravical.read`.

    >>> session = gravical.simulate("poses", free=8, seed=3)
    >>> calibration = gravical.calibrate(session.recordings, gravity=9.80665)
    >>> calibration.verdict.grade, len(calibration.accelerometer.bias)
    ('good', 3)
    """
    return Calibration._of(_run("calibrate", session, options))


def apply(
    calibration: Any,
    recording: Any,
    *,
    output: Path | None = None,
    force: bool = False,
    **options: Unpack[_types.ApplyOptions],
) -> Result:
    """Apply a calibration (a Calibration, path, or object of imucal) to a recording, whose unit and
    range are checked (``unit-mismatch``). The arrays of the result are ``t``, ``accel``, ``gyro``.

    - ``output``: go from file to file, in constant memory, as the program: all other columns are
      copied, values have six decimals; ``force`` overwrites, ``keep_raw`` keeps the raw columns.
    - ``output_unit``: ``"m/s^2"`` (the default) or ``"g"``.
    - ``axes`` as of :func:`gravical.calibrate`, and the keywords of :func:`gravical.read`.
    """
    target = None if output is None else (output, force)
    done = _run("apply", recording, options, calibration, target=target)
    return Result._of(done, (("t", 1), ("accel", 3), ("gyro", 3)))


def denoise(recording: Any, filter: Any, **options: Unpack[_types.DenoiseOptions]) -> Result:
    """Filter a recording and report the effect on its noise: ``recording`` of the result. Breaks, gaps
    and empty cells are respected; uneven time stamps are refused (``uneven-stamps``).

    - ``filter``: one or a list of ``"savgol:WINDOW,ORDER"``, ``"butter:ORDER,CUTOFFHz"``,
      ``"highpass:…"``, ``"hampel:WINDOW,SIGMAS"``, in this order.
    - The keywords of :func:`gravical.read`.
    """
    done = _run("denoise", recording, {**options, "filter": filter})
    return Result._of(done, recording=Recording(done.recording()))


def noise(recording: Any, **options: Unpack[_types.NoiseOptions]) -> Result:
    """Determine the noise of a sensor (Allan deviation) from a recording in which it lies still for
    ten seconds (else ``not-at-rest``); what moves is left out. Keywords are those of
    :func:`gravical.read`."""
    return Result._of(_run("noise", recording, options))


def check(calibration: Any, session: Any, **options: Unpack[_types.CheckOptions]) -> Result:
    """Test whether a calibration still fits new recordings at rest, of which one in any pose is enough.

    Its keywords are ``gravity``, ``latitude``, ``altitude`` (by default that of the calibration) and
    ``axes``, as of :func:`gravical.calibrate`, and those of :func:`gravical.read`.
    ``verdict.judgement`` is ``"agrees"``, ``"does-not-fit"`` or ``"undecided"``.
    """
    return Result._of(_run("check", session, options, calibration))


def compare(first: Any, second: Any) -> Result:
    """Test whether two calibrations, paths of them, or objects of imucal differ by more than their
    uncertainty: ``verdict.judgement`` is ``"agrees"``, ``"differs"`` or ``"undecided"``."""
    (a, name_a), (b, name_b) = calibration_of(first), calibration_of(second)
    if name_a == name_b:
        name_a, name_b = f"first {name_a}", f"second {name_b}"
    pair = [(a, name_a), (b, name_b)]
    return Result._of(_gravical.run("compare", [], pair, None, keywords({})))


def motion(recording: Any, calibration: Any = None, **options: Unpack[_types.MotionOptions]) -> Result:
    """Compute velocity and position with error bands.

    The result has the arrays of :class:`Result`; its ``verdict.judgement`` is ``"usable"``,
    ``"rough"``, ``"position-not-known"``, ``"open"`` or ``"at-rest"``.

    - ``recording``: with rests of some seconds before and after each move.
    - ``calibration``: a Calibration, path, or object of imucal; without it the nominal scales.
    - ``procedure``: ``"strapdown"``, ``"constant-tilt"``, or ``"report"`` for that of the student report.
    - ``rests``, s: ``"0-5,7.2-"`` or ``[(0, 5), (7.2, None)]``; by default found.
    - ``no_stances``: take no moment between swings for a foot in stance.
    - ``gravity``, ``latitude``, ``altitude`` (by default that of the calibration) and ``axes`` as of
      :func:`gravical.calibrate`, and the keywords of :func:`gravical.read`.
    """
    given = () if calibration is None else (calibration,)
    return Result._of(_run("motion", recording, options, *given), _MOTION)


def orient(recording: Any, calibration: Any = None, **options: Unpack[_types.OrientOptions]) -> Result:
    """Compute the orientation with its uncertainty: ``verdict.judgement`` is ``"known"``,
    ``"partly-known"`` or ``"not-known"``. Heading is relative to the start.

    - ``acceleration``: with the acceleration without gravity, an array of the result.
    - The others as of :func:`gravical.motion`.
    """
    given = () if calibration is None else (calibration,)
    return Result._of(_run("orient", recording, options, *given), _ORIENTATION)


def simulate(
    scenario: str, *, output: Path | None = None, force: bool = False, **options: Unpack[_types.SimulateOptions]
) -> Result:
    """Simulate recordings of an MPU6050 with known true errors. The result is the truth, ``truth.json``
    of the program; ``recordings`` has the names of the files.

    - ``scenario``: ``"six-position"``, ``"poses"``, ``"static"`` or ``"line"``.
    - ``output``: folder to write to, as the program. Without it nothing is left on the disk.
    - Others as of ``gravical simulate SCENARIO --help``: ``seed``, ``free``, ``rate`` (Hz), ``tilt``
      (°), ``duration`` (s), ``distance`` (m), ``raw`` …
    """
    with tempfile.TemporaryDirectory(prefix="gravical-") as folder:
        target = folder if output is None else output
        truth, paths = _gravical.simulate(str(scenario), target, force, keywords(options))
        named = [(os.path.basename(path), path) for path in paths[:-1]]
        recordings = {name: read(path, name=name) for name, path in named}
    if output is None:
        for recording in recordings.values():
            # Its file is gone.
            recording._source = None
    kept = [] if output is None else [str(path) for path in paths]
    summary = f"simulated: {', '.join(recordings)}"
    return Result(parsed(truth), recordings=recordings, paths=kept, _summary=summary)


def export_targets() -> dict[str, str]:
    """The targets of :meth:`Result.export`, each with what it holds."""
    return dict(_gravical.export_targets())


def __dir__() -> list[str]:
    return __all__
