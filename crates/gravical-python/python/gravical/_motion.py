"""Motion: of a whole recording, and sample by sample."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypedDict

import numpy as np
import numpy.typing as npt

from . import _gravical, _tables
from ._calibration import Calibration, calibration_of, noise_of
from ._errors import usage
from ._findings import Finding
from ._recording import Recording, Source, path_of, read
from ._results import Judged, NoiseResult
from ._types import Floats, Path, Reading, options

if TYPE_CHECKING:
    from typing_extensions import Unpack


class MotionOptions(TypedDict, total=False):
    """How motion is computed. All are optional.

    ``gravity``, ``latitude``, ``altitude``: local gravity, by default that of the calibration.
    ``procedure``: ``"default"``, or ``"report"`` for that of the student report.
    ``gravity_removal``: ``"strapdown"``, ``"constant-tilt"`` or ``"initial-mean"``, the mean of the
    first 500 rows. ``causal``: use the past only. ``smooth``: filters of the accelerometer;
    ``zero_velocity``: updates at rests. ``rests``: pairs of seconds, by default found.
    ``stances``: highest angular rate of a walking foot in stance, rad/s, for updates there; False for
    none. ``v0``: velocity of the first rest without zero-velocity updates, m/s.
    ``p0``: position at the start, m. ``no_bands``: no error bands.
    ``axes``: sensor axes that point along x, y and z of the case.
    """

    gravity: float | None
    latitude: float | None
    altitude: float | None
    procedure: Literal["default", "report"] | None
    gravity_removal: Literal["strapdown", "constant-tilt", "initial-mean"] | None
    causal: bool | None
    smooth: str | Sequence[str] | None
    zero_velocity: bool | None
    rests: str | Sequence[tuple[float, float | None]] | None
    stances: float | bool | None
    v0: Sequence[float] | None
    p0: Sequence[float] | None
    no_bands: bool | None
    axes: str | Sequence[str] | None


_MOTION = frozenset(MotionOptions.__annotations__)


class _MotionArguments(MotionOptions, Reading, total=False):
    """Both."""


def _parted(arguments: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    own = {name: value for name, value in arguments.items() if name in _MOTION}
    reading = {name: value for name, value in arguments.items() if name not in _MOTION}
    options(reading)
    return own, reading


class MotionResult(Judged, _tables.Columns):
    """Velocity and position: :func:`gravical.motion`.

    The arrays are read-only views, one row for each sample that was used. What is not known is NaN.
    The verdict is ``"bounded"``, ``"partly-open"``, ``"open"``, ``"at-rest"`` or ``"not-usable"``.
    """

    def __init__(self, native: _gravical.Outcome) -> None:
        super().__init__(native)
        self._still = native.still()
        self._arrays: dict[str, Floats] = {
            name: native.track(name).reshape((-1, width) if width > 1 else -1)
            for name, width in _TRACK.items()
        }

    @property
    def t(self) -> Floats:
        """Time, s, shape (n,)."""
        return self._arrays["t"]

    @property
    def position(self) -> Floats:
        """Position, m, shape (n, 3)."""
        return self._arrays["position"]

    @property
    def velocity(self) -> Floats:
        """Velocity, m/s, shape (n, 3)."""
        return self._arrays["velocity"]

    @property
    def acceleration(self) -> Floats:
        """Acceleration without gravity, m/s², shape (n, 3)."""
        return self._arrays["acceleration"]

    @property
    def attitude(self) -> Floats:
        """Attitude as the quaternion w, x, y, z, sensor → frame, shape (n, 4)."""
        return self._arrays["attitude"]

    @property
    def sigma_position(self) -> Floats | None:
        """Standard uncertainty of the position, m, shape (n, 3); None without bands."""
        sigma = self._arrays["sigma_position"]
        return sigma if len(sigma) else None

    @property
    def sigma_velocity(self) -> Floats | None:
        """Standard uncertainty of the velocity, m/s, shape (n, 3); None without bands."""
        sigma = self._arrays["sigma_velocity"]
        return sigma if len(sigma) else None

    @property
    def force(self) -> Floats:
        """Calibrated specific force, m/s², shape (n, 3): a new array."""
        return np.stack([self._arrays[f"force_{axis}"] for axis in "xyz"], axis=1)

    @property
    def raw(self) -> Floats:
        """Specific force by the nominal scale alone, m/s², shape (n, 3): a new array."""
        return np.stack([self._arrays[f"raw_{axis}"] for axis in "xyz"], axis=1)

    @property
    def still(self) -> npt.NDArray[np.bool_]:
        """True at rest, shape (n,)."""
        return self._still

    @property
    def moves(self) -> list[dict[str, Any]]:
        """Each move with ``displacement_m``, ``sigma_m`` and what else the program says of it."""
        return list(self._dict["moves"])

    @property
    def rests(self) -> list[tuple[float, float]]:
        """Start and end of each rest, s."""
        return [(rest["start_s"], rest["end_s"]) for rest in self._dict["rests"]]

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write the table of the program (CSV)."""
        self._computed().table(path, force)

    def _named(self) -> dict[str, Any]:
        columns: dict[str, Any] = {"t_s": self.t}

        def add(names: str, values: Floats | None) -> None:
            if values is not None:
                columns.update({name: values[:, i] for i, name in enumerate(names.split())})

        add("raw_ax_mps2 raw_ay_mps2 raw_az_mps2", self.raw)
        add("ax_mps2 ay_mps2 az_mps2", self.force)
        columns["still"] = self.still
        add("qw qx qy qz", self.attitude)
        add("lin_ax_mps2 lin_ay_mps2 lin_az_mps2", self.acceleration)
        add("vx_mps vy_mps vz_mps", self.velocity)
        add("px_m py_m pz_m", self.position)
        add("sigma_vx_mps sigma_vy_mps sigma_vz_mps", self.sigma_velocity)
        add("sigma_px_m sigma_py_m sigma_pz_m", self.sigma_position)
        return columns


#: Columns of the native part, with their widths.
_TRACK = {
    "t": 1,
    "attitude": 4,
    **dict.fromkeys(("position", "velocity", "acceleration"), 3),
    **dict.fromkeys(("sigma_position", "sigma_velocity"), 3),
    **dict.fromkeys(("raw_x", "raw_y", "raw_z", "force_x", "force_y", "force_z"), 1),
}


def motion(
    recording: Source,
    calibration: Calibration | Path | None = None,
    *,
    gyro: Path | None = None,
    noise: NoiseResult | Path | None = None,
    truth: Path | None = None,
    **arguments: Unpack[_MotionArguments],
) -> MotionResult:
    """Compute velocity and position with error bands.

    Parameters
    ----------
    recording : path, recording or table
        With rests of some seconds before and after each move.
    calibration : Calibration, path, or object of imucal, optional
        Without it the nominal scales are used.
    gyro : path, optional
        Gyroscope of the recording in a second file.
    noise : NoiseResult or path, optional
        Noise of the sensor for the bands. By default that of the rests.
    truth : path, optional
        Reference positions, columns t_s, px_m, py_m, pz_m, that the result is compared with.
    **arguments
        How motion is computed: see :class:`MotionOptions`; how the recording is read: see
        :class:`Reading`.

    Returns
    -------
    MotionResult

    Raises
    ------
    InputError
        ``unit-mismatch``, ``unit-unknown``, ``rate-unknown``, ``no-samples``.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> moved = gravical.motion(line, calibration)
    >>> moved.verdict == "bounded", moved.position.shape
    (True, (1200, 3))
    """
    own, reading = _parted(dict(arguments))
    given = options({}, **own, truth=truth)
    native, name = (None, "") if calibration is None else calibration_of(calibration)
    rows = read(recording, gyro=gyro, **reading)
    return MotionResult(
        _gravical.motion(rows._native, native, name, noise_of(noise), given)
    )


class State(NamedTuple):
    """What is known after a sample; NaN what is not."""

    t: float
    force: Floats
    attitude: Floats
    acceleration: Floats
    velocity: Floats
    position: Floats
    #: Standard uncertainties of both.
    sigma_velocity: Floats
    sigma_position: Floats
    still: bool
    #: False if the sample was left out: a value is missing, or its time falls behind.
    taken: bool


class States(NamedTuple):
    """What is known after each sample of a chunk, one row each; NaN what is not."""

    t: Floats
    force: Floats
    attitude: Floats
    acceleration: Floats
    velocity: Floats
    position: Floats
    #: Standard uncertainties of both.
    sigma_velocity: Floats
    sigma_position: Floats
    still: npt.NDArray[np.bool_]
    #: False for samples that were left out.
    taken: npt.NDArray[np.bool_]


class Motion:
    """Velocity and position of samples as they arrive, without look-ahead.

    At rest the numbers and bands are those of ``gravical motion --causal``, which goes through a
    move again once a rest has closed it. A rest is known 1 s after it began. Where the whole
    recording is there, :func:`gravical.motion` is more accurate.

    The noise is learned from the first 3 s of the first rest of the samples that come. Until then
    the motion is not known.

    Parameters
    ----------
    first : path, recording or table
        Some seconds that tell units and rate. Their samples are not taken: pass them to
        :meth:`extend`, if they are part of the motion.
    calibration : Calibration, path, or object of imucal, optional
        Without it the nominal scales are used.
    **arguments
        How motion is computed: see :class:`MotionOptions`; how the recording is read: see
        :class:`Reading`. ``no_bands`` has no effect.

    Raises
    ------
    UsageError
        ``option-range`` for what needs the whole recording: ``smooth``, and the initial mean.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> live = gravical.Motion(line, calibration)
    >>> first = live.update(line.t[0], line.accel[0], line.gyro[0])
    >>> rest = live.extend(line.t[1:], line.accel[1:], line.gyro[1:])
    >>> rest.position.shape
    (1199, 3)
    """

    def __init__(
        self,
        first: Source,
        calibration: Calibration | Path | None = None,
        **arguments: Unpack[_MotionArguments],
    ) -> None:
        own, reading = _parted(dict(arguments))
        native, name = (None, "") if calibration is None else calibration_of(calibration)
        rows = read(first, **reading)
        self._timed = rows.t is not None
        self._native = _gravical.Stepper(rows._native, native, name, options({}, **own))

    def update(
        self,
        t: float | None,
        accel: Any,
        gyro: Any = None,
        temperature: float | None = None,
    ) -> State:
        """Take one sample.

        Parameters
        ----------
        t : float or None
            Time, s, from any origin; None if samples are evenly spaced at the rate of ``first``.
        accel : array of shape (3,)
            Raw specific force, in the unit of ``first``. NaN for a value that is missing.
        gyro : array of shape (3,), optional
            Raw angular rate.
        temperature : float, optional
            °C.

        Returns
        -------
        State
        """
        row = np.full((1, 8), np.nan)
        try:
            row[0, 0] = np.nan if t is None else t
            row[0, 1:4] = accel
            if gyro is not None:
                row[0, 4:7] = gyro
            if temperature is not None:
                row[0, 7] = temperature
        except (TypeError, ValueError) as error:
            raise usage(
                f"this is no sample: {error}",
                "give a time in s and three numbers for each sensor",
            ) from None
        self._check_time(t is not None)
        out, still, taken = self._native.update(row, t is not None)
        o = out[0]
        return State(
            float(o[0]),
            o[1:4],
            o[4:8],
            o[8:11],
            o[11:14],
            o[14:17],
            o[17:20],
            o[20:23],
            bool(still[0]),
            bool(taken[0]),
        )

    def extend(self, t: Any, accel: Any, gyro: Any = None, temperature: Any = None) -> States:
        """Take a chunk of samples: arrays of shape (n,) and (n, 3), as of :meth:`update`."""
        xyz = _tables.vectors(accel, "accel")
        rows = np.full((len(xyz), 8), np.nan)
        if t is not None:
            rows[:, 0] = _tables.scalars(t, "t", len(xyz))
        rows[:, 1:4] = xyz
        if gyro is not None:
            rows[:, 4:7] = _tables.vectors(gyro, "gyro", len(xyz))
        if temperature is not None:
            rows[:, 7] = _tables.scalars(temperature, "temperature", len(xyz))
        self._check_time(t is not None)
        o, still, taken = self._native.update(rows, t is not None)
        return States(
            o[:, 0],
            o[:, 1:4],
            o[:, 4:8],
            o[:, 8:11],
            o[:, 11:14],
            o[:, 14:17],
            o[:, 17:20],
            o[:, 20:23],
            still,
            taken,
        )

    def _check_time(self, given: bool) -> None:
        if given != self._timed:
            raise usage(
                "t= is given, but the first recording has no time stamps"
                if given
                else "t= is missing: the first recording has time stamps",
                "give times for both or for none of them",
            )

    def interrupt(self) -> None:
        """Something is missing here: what follows is not known before the next rest, and the
        position not any more."""
        self._native.interrupt()

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return self._native.samples

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is odd about the first recording."""
        return Finding._all(json.loads(self._native.findings_json()))

    def __repr__(self) -> str:
        return f"<Motion after {self.samples} samples>"
