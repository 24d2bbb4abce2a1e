"""Calibrations."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _gravical, _tables
from ._errors import usage
from ._findings import Verdict
from ._recording import Source, session_of
from ._results import Judged, NoiseResult
from ._types import Floats, Path, Reading, options, text

if TYPE_CHECKING:
    from typing_extensions import Unpack

Method = Literal["joint", "ferraris"]


class Calibration(Judged):
    """A calibration of one sensor: calibrated = matrix · (raw − bias).

    Made by :func:`gravical.calibrate`, :meth:`load` or :meth:`from_imucal`. It cannot be changed,
    and can be pickled.
    """

    _native: _gravical.Calibration

    def __init__(self, native: _gravical.Calibration) -> None:
        if not isinstance(native, _gravical.Calibration):
            raise usage(
                "a calibration is not made of this",
                "use gravical.calibrate(…) or Calibration.load(path)",
            )
        super().__init__(native)

    @classmethod
    def load(cls, path: Path) -> Calibration:
        """Read a calibration file, of gravical or of imucal.

        Raises
        ------
        NotFoundError
            There is no such file.
        InputError
            ``calibration-syntax`` and others: it holds no calibration.
        """
        return cls(_gravical.Calibration.read(path))

    @classmethod
    def from_json(cls, text: str) -> Calibration:
        """The calibration in the text of a file, of gravical or of imucal."""
        return cls(_gravical.Calibration.parse(text))

    def to_json(self) -> str:
        """The text of the file."""
        return self._native.json()

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write the calibration file, atomically. Nothing is overwritten without ``force``.

        Raises
        ------
        ExistsError
            The file is there, and ``force`` is false.
        """
        self._native.write(path, force)

    @property
    def verdict(self) -> Verdict:
        """``"good"``, ``"fair"``, ``"not-verifiable"`` or ``"poor"``, with its ``reasons``."""
        return super().verdict

    @property
    def unit(self) -> str:
        """Unit of the raw acceleration that it takes."""
        return str(self._dict["accelerometer"]["input_unit"])

    @property
    def bias(self) -> Floats:
        """Bias of the accelerometer, shape (3,), in ``unit``."""
        return np.array(self._dict["accelerometer"]["bias"])

    @property
    def matrix(self) -> Floats:
        """Matrix of the accelerometer, shape (3, 3), m/s² per ``unit``."""
        return np.array(self._dict["accelerometer"]["matrix"])

    @property
    def scale(self) -> Floats:
        """Scale factors of the accelerometer, shape (3,), ``unit`` per m/s²."""
        return np.array(self._dict["accelerometer"]["scale"])

    @property
    def covariance(self) -> Floats | None:
        """Covariance of the parameters M (row by row) and b of raw = M · a + b, and of the six bends
        if they were fitted: shape (18, 18) or (12, 12). None if the method does not compute it.
        ``covariance_parameters`` names the rows."""
        found = self._dict["accelerometer"]["covariance"]
        return None if found is None else np.array(found["values"])

    @property
    def covariance_parameters(self) -> list[str]:
        """Names of the rows of ``covariance``."""
        found = self._dict["accelerometer"]["covariance"]
        return [] if found is None else list(found["parameters"])

    @property
    def has_gyroscope(self) -> bool:
        """True if the gyroscope is calibrated."""
        return self._dict["gyroscope"] is not None

    def _gyroscope(self, name: str) -> Any:
        section = self._dict["gyroscope"]
        return None if section is None else section[name]

    @property
    def gyro_unit(self) -> str | None:
        """Unit of the raw angular rate that it takes; None without a gyroscope."""
        unit = self._gyroscope("input_unit")
        return None if unit is None else str(unit)

    @property
    def gyro_bias(self) -> Floats | None:
        """Bias of the gyroscope, shape (3,), in ``gyro_unit``; None without one."""
        bias = self._gyroscope("bias")
        return None if bias is None else np.array(bias)

    @property
    def gyro_matrix(self) -> Floats | None:
        """Matrix of the gyroscope, shape (3, 3), rad/s per ``gyro_unit``; None without one."""
        matrix = self._gyroscope("matrix")
        return None if matrix is None else np.array(matrix)

    @property
    def poses(self) -> list[dict[str, Any]]:
        """The poses, each with its errors."""
        return list(self._dict["accelerometer"]["poses"])

    @property
    def gravity(self) -> float:
        """Local gravity that the scale is based on, m/s²."""
        return float(self._dict["gravity_mps2"])

    @property
    def worst_direction_error(self) -> float | None:
        """Limit (95 %) of the error of the magnitude at rest in any direction, m/s²."""
        worst = self._dict["accelerometer"]["worst_direction"]
        return None if worst is None else float(worst["error_mps2"])

    def apply(self, accel: Any) -> Floats:
        """Calibrated specific force of raw readings.

        Nothing is checked but the shape: units are those of the calibration. For a whole recording,
        with its unit, range and temperature checked, see :func:`gravical.apply`.

        Parameters
        ----------
        accel : array of shape (n, 3) or (3,)
            Raw readings in ``unit``.

        Returns
        -------
        array of the same shape
            m/s². A row with NaN stays NaN.

        Examples
        --------
        >>> calibration.apply([[0.1, 0.2, 9.7]]).shape
        (1, 3)
        """
        raw = np.asarray(accel)
        if raw.ndim == 1:
            one: Floats = self._native.apply_accel(_tables.vectors(raw[np.newaxis], "accel"))[0]
            return one
        return self._native.apply_accel(_tables.vectors(raw, "accel"))

    def apply_gyro(self, gyro: Any, accel: Any = None) -> Floats:
        """Calibrated angular rate of raw readings.

        Parameters
        ----------
        gyro : array of shape (n, 3) or (3,)
            Raw readings in ``gyro_unit``.
        accel : array of the same shape, optional
            *Calibrated* specific force, m/s², for the g-sensitivity.

        Returns
        -------
        array of the same shape
            rad/s.

        Raises
        ------
        UsageError
            ``gyro-not-calibrated``.
        """
        raw = np.asarray(gyro)
        if raw.ndim == 1:
            force = None if accel is None else np.asarray(accel)[np.newaxis]
            one: Floats = self.apply_gyro(raw[np.newaxis], force)[0]
            return one
        rows = _tables.vectors(raw, "gyro")
        force = None if accel is None else _tables.vectors(accel, "accel", len(rows))
        return self._native.apply_gyro(rows, force)

    def export(
        self,
        to: str,
        output: Path | None = None,
        *,
        force: bool = False,
        name: str | None = None,
        device_id: int | None = None,
        rotation: str | Sequence[str] | None = None,
        counts_per_g: float | None = None,
        counts_per_deg_s: float | None = None,
        upper_limit: bool | None = None,
    ) -> str:
        """The calibration in the format of another program.

        Parameters
        ----------
        to : str
            ``"c"``, ``"arduino"``, ``"rust"``, ``"python"``, ``"matlab"``, ``"ros"``, ``"ros2"``,
            ``"kalibr"``, ``"px4"``, ``"ardupilot"``, ``"mpu6050"``, ``"imucal"`` or
            ``"gravical"``. :func:`gravical.export_targets` says what each holds.
        output : path, optional
            File to write, too.
        name, device_id, rotation, counts_per_g, counts_per_deg_s, upper_limit
            Options of some targets, as of the program.

        Returns
        -------
        str
            The text of the file. What the target cannot hold is said in it, and as warnings
            (:class:`gravical.ExportWarning`).
        """
        import warnings

        given = options(
            {},
            name=name,
            device_id=device_id,
            rotation=rotation,
            counts_per_g=counts_per_g,
            counts_per_deg_s=counts_per_deg_s,
            upper_limit=upper_limit,
        )
        written, notes = self._native.export(text(to, "to"), given)
        for note in notes:
            warnings.warn(note, ExportWarning, stacklevel=2)
        if output is not None:
            _gravical.write_text(output, written, force)
        return written

    @classmethod
    def from_imucal(cls, calibration: Any) -> Calibration:
        """The calibration of an object of imucal, such as ``FerrarisCalibrationInfo``.

        Raises
        ------
        UsageError
            It is no such object.
        InputError
            It holds what gravical cannot take over.
        """
        if not hasattr(calibration, "to_json"):
            raise usage(
                f"a {type(calibration).__name__} is no calibration of imucal",
                "give a FerrarisCalibrationInfo, or a path to Calibration.load",
            )
        return cls.from_json(calibration.to_json())

    def to_imucal(self) -> Any:
        """The calibration as an object of imucal, which has to be installed.

        What imucal cannot hold is said as warnings (:class:`gravical.ExportWarning`).
        """
        from imucal import CalibrationInfo

        return CalibrationInfo.from_json(self.export("imucal"))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Calibration) and self._dict == other._dict

    def __hash__(self) -> int:
        return hash(self.to_json())

    def __reduce__(self) -> tuple[Any, ...]:
        return Calibration.from_json, (self.to_json(),)


class ExportWarning(UserWarning):
    """What a target of an export cannot hold."""


def calibration_of(given: Any) -> tuple[_gravical.Calibration, str]:
    """The calibration and its name: a path is read."""
    if isinstance(given, Calibration):
        return given._native, "calibration"
    if isinstance(given, (str, os.PathLike)):
        return _gravical.Calibration.read(given), os.fspath(given)
    if hasattr(given, "to_json") and type(given).__module__.startswith("imucal"):
        return Calibration.from_imucal(given)._native, "imucal"
    raise usage(
        f"a {type(given).__name__} is no calibration",
        "give a Calibration, the path of its file, or an object of imucal",
    )


def noise_of(noise: NoiseResult | Path | None) -> _gravical.Outcome | Path | None:
    """The noise of a sensor for the native part."""
    if isinstance(noise, NoiseResult):
        native: _gravical.Outcome = noise._computed()
        return native
    if noise is None or isinstance(noise, (str, os.PathLike)):
        return noise
    raise usage("noise= is no noise", "give the result of gravical.noise, or the path of its file")


def calibrate(
    session: Source | Sequence[Source],
    *,
    gravity: float | None = None,
    latitude: float | None = None,
    altitude: float | None = None,
    method: Method | None = None,
    gyro: Path | None = None,
    sections: Path | None = None,
    rows: int | None = None,
    faces_from: Literal["data", "names"] | None = None,
    turn_angle: float | None = None,
    pose_tilt: float | None = None,
    prior: Literal["data-sheet", "off"] | None = None,
    free_pose: str | Sequence[str] | None = None,
    face_pose: str | Sequence[str] | None = None,
    thermal: Path | Sequence[Path] | None = None,
    noise: NoiseResult | Path | None = None,
    sensor_id: str | None = None,
    sensor_model: str | None = None,
    recorded: str | None = None,
    axes: str | Sequence[str] | None = None,
    **reading: Unpack[Reading],
) -> Calibration:
    """Calibrate a sensor from recordings of static poses.

    Parameters
    ----------
    session : path, recording, table, or several of them
        The recordings of one session: files, a folder, :class:`Recording` objects, data frames, or
        one continuous recording in which the poses are found. A mapping from the name of a pose
        (``"+x"``, ``"-x"`` …) to a recording, table or array of shape (n, 3) names the poses.
    gravity : float, optional
        Local gravity, m/s². By default 9.80665 ± 0.15 %.
    latitude, altitude : float, optional
        Latitude in degrees and height in m, from which gravity is computed.
    method : str, optional
        ``"joint"`` (the default: face and free poses in one fit that allows for tilted faces) or
        ``"ferraris"`` (six faces in closed form).
    gyro : path, optional
        Gyroscope of the one recording in a second file.
    sections : path, optional
        Poses as ranges of rows: JSON of imucal, or CSV label,start,end.
    rows : int, optional
        The first so many rows of each pose. By default its longest static interval.
    faces_from : str, optional
        What decides which face was up: ``"data"`` (the default) or ``"names"``.
    turn_angle : float, optional
        Signed angle of the turns about each axis, degrees. By default −360.
    pose_tilt : float, optional
        Expected tilt of the face poses, degrees (standard deviation). By default estimated.
    prior : str, optional
        ``"data-sheet"`` (the default) or ``"off"``.
    free_pose, face_pose : str or list of str, optional
        Poses that are to be treated as free, or as faces.
    thermal : path or list of paths, optional
        Recordings at rest while the sensor warms or cools, for a temperature model.
    noise : NoiseResult or path, optional
        Noise of the sensor, stored in the calibration.
    sensor_id, sensor_model, recorded : str, optional
        What is stored of the sensor and of the time of the session.
    axes : str or sequence, optional
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    **reading
        How recordings are read: see :class:`Reading`.

    Returns
    -------
    Calibration
        With ``bias``, ``matrix``, ``covariance``, ``verdict``, ``findings``. A result that cannot be
        trusted is no exception: its verdict is ``"poor"``.

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
    >>> calibration.verdict
    Verdict('good', ...)
    >>> calibration.bias.shape, calibration.matrix.shape, calibration.covariance.shape
    ((3,), (3, 3), (18, 18))
    """
    given = options(
        reading,
        gravity=gravity,
        latitude=latitude,
        altitude=altitude,
        method=method,
        sections=sections,
        rows=rows,
        faces_from=faces_from,
        turn_angle=turn_angle,
        pose_tilt=pose_tilt,
        prior=prior,
        free_pose=free_pose,
        face_pose=face_pose,
        thermal=thermal,
        sensor_id=sensor_id,
        sensor_model=sensor_model,
        recorded=recorded,
        axes=axes,
    )
    paths, recordings = session_of(session, reading)
    of_sensor = noise_of(noise)
    if paths is not None:
        return Calibration(_gravical.calibrate_paths(paths, gyro, of_sensor, given))
    if gyro is not None:
        raise usage("gyro= joins two files", "read both first: gravical.read(path, gyro=path)")
    return Calibration(_gravical.calibrate_recordings(recordings or [], of_sensor, given))


def export_targets() -> dict[str, str]:
    """The targets of :meth:`Calibration.export`, each with what it holds."""
    return dict(_gravical.export_targets())
