"""Motion: of a whole recording, and sample by sample."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _gravical, _tables
from ._errors import UsageError
from ._keywords import Floats, Path, keywords
from ._recording import native_source
from ._result import Record, Result, calibration_of, noise_of, parsed


def motion(
    recording: Any,
    calibration: Any = None,
    *,
    noise: Result | Path | None = None,
    **options: Any,
) -> Result:
    """Compute velocity and position with error bands.

    Parameters
    ----------
    recording : path, recording or table
        With rests of some seconds before and after each move.
    calibration : Calibration, path, or object of imucal, optional
        Without it the nominal scales are used.
    noise : result of :func:`gravical.noise`, or path of its file, optional
        Noise of the sensor for the bands. By default that of the rests.
    truth : path
        Reference positions, columns t_s, px_m, py_m, pz_m, that the result is compared with.
    gravity, latitude, altitude : float
        Local gravity, m/s², or place, ° and m. By default that of the calibration.
    procedure : str
        ``"report"``: that of the student report, to compare with.
    gravity_removal : str
        ``"strapdown"`` (the default), ``"constant-tilt"`` or ``"initial-mean"``, the mean of the
        first 500 rows.
    causal : bool
        Use the past only.
    smooth : str or list of str
        Filters of the accelerometer, as of :func:`gravical.denoise`.
    zero_velocity : bool
        Updates at rests.
    rests : str or list of pairs
        Rests in s: ``"0-5,7.2-"`` or ``[(0, 5), (7.2, None)]``. By default found.
    stances : float or bool
        Highest angular rate of a walking foot in stance, rad/s, for updates there; False for none.
    v0, p0 : sequence of float
        Velocity of the first rest without zero-velocity updates, m/s; position at the start, m.
    no_bands : bool
        No error bands.
    axes : str or sequence
        Sensor axes that point along x, y and z of the case: ``"y,-x,z"``.
    **options
        How it is read: those of :func:`gravical.read`.

    Returns
    -------
    Result
        With the arrays ``t``, ``position``, ``velocity``, ``sigma_position`` … of
        :class:`Result`. ``verdict.judgement`` is ``"bounded"``, ``"partly-open"``, ``"open"``,
        ``"at-rest"`` or ``"not-usable"``.

    Raises
    ------
    InputError
        ``unit-mismatch``, ``unit-unknown``, ``rate-unknown``, ``no-samples``.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> moved = gravical.motion(line, calibration)
    >>> moved.verdict.judgement, moved.position.shape
    ('bounded', (1200, 3))
    """
    source, extra = native_source(recording)
    native, name = (None, "") if calibration is None else calibration_of(calibration)
    given = keywords({**extra, **options})
    return Result._of(_gravical.motion(source, native, name, noise_of(noise), given))


class States(NamedTuple):
    """What is known after each sample of a chunk, one row each; NaN what is not. Of
    :meth:`Motion.update` the values of one sample."""

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
    #: False for samples that were left out: a value is missing or beyond any sensor, or the time
    #: falls behind.
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
    **options
        Those of :func:`gravical.motion` that need no recording as a whole.

    Raises
    ------
    UsageError
        ``option-range`` for what needs the whole recording: ``smooth``, ``rests``, ``zero_velocity=False``,
        ``noise`` and the initial mean.

    Examples
    --------
    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> live = gravical.Motion(line, calibration)
    >>> first = live.update(line.t[0], line.accel[0], line.gyro[0])
    >>> rest = live.extend(line.t[1:], line.accel[1:], line.gyro[1:])
    >>> rest.position.shape
    (1199, 3)
    """

    def __init__(self, first: Any, calibration: Any = None, **options: Any) -> None:
        native, name = (None, "") if calibration is None else calibration_of(calibration)
        source, extra = native_source(first)
        self._native = _gravical.Stepper(source, native, name, keywords({**extra, **options}))

    def update(self, t: Any, accel: Any, gyro: Any = None, temperature: Any = None) -> States:
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
        """
        one = [None if value is None else [value] for value in (t, accel, gyro, temperature)]
        return States(*(values[0] for values in self.extend(*one)))

    def extend(self, t: Any, accel: Any, gyro: Any = None, temperature: Any = None) -> States:
        """Take a chunk of samples: arrays of shape (n,) and (n, 3), as of :meth:`update`."""
        if (t is not None) != self._native.timed:
            message = "t= is given, but the first recording has no time stamps"
            if t is None:
                message = "t= is missing: the first recording has time stamps"
            raise UsageError(message, hint="give times for both or for none of them")
        xyz = _tables.vectors(accel, "accel")
        rows = np.full((len(xyz), 8), np.nan)
        rows[:, 1:4] = xyz
        if t is not None:
            rows[:, 0] = _tables.scalars(t, "t", len(xyz))
        if gyro is not None:
            rows[:, 4:7] = _tables.vectors(gyro, "gyro", len(xyz))
        if temperature is not None:
            rows[:, 7] = _tables.scalars(temperature, "temperature", len(xyz))
        o, still, taken = self._native.update(rows, t is not None)
        t, force, attitude, *rest = np.split(o, [1, 4, 8, 11, 14, 17, 20], axis=1)
        acceleration, velocity, position, sigma_velocity, sigma_position = rest
        return States(
            t[:, 0],
            force,
            attitude,
            acceleration,
            velocity,
            position,
            sigma_velocity,
            sigma_position,
            still,
            taken,
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
    def findings(self) -> list[Record]:
        """What is odd about the first recording."""
        return list(parsed(self._native.findings_json()))
