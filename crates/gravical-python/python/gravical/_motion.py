"""Motion sample by sample."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _gravical
from ._arguments import Floats, keywords, scalars, vectors
from ._errors import UsageError
from ._recording import session_of
from ._result import Groups, Record, calibration_of, parsed, split

#: The arrays of a motion.
MOTION: Groups = (
    ("t", 1), ("raw", 3), ("force", 3), ("still", 1), ("attitude", 4), ("acceleration", 3),
    ("velocity", 3), ("position", 3), ("sigma_velocity", 3), ("sigma_position", 3),
)  # fmt: skip


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
    move again once a rest has closed it. A rest is known 1 s after it began. The noise is learned
    from the first 3 s of the first rest of the samples that come; until then the motion is not
    known. Where the whole recording is there, :func:`gravical.motion` is more accurate.

    - ``first``: some seconds that tell units and rate. Their samples are not taken: pass them to
      :meth:`extend`, if they are part of the motion.
    - ``calibration`` as of :func:`gravical.motion`, and those of its keywords that need no recording
      as a whole (else ``option-range``): not ``smooth``, ``rests``, ``zero_velocity=False``, the
      initial mean.

    >>> line = gravical.simulate("line", seed=3).recordings["line.csv"]
    >>> live = gravical.Motion(line, calibration)
    >>> first = live.update(line.t[0], line.accel[0], line.gyro[0])
    >>> rest = live.extend(line.t[1:], line.accel[1:], line.gyro[1:])
    >>> rest.position.shape
    (1199, 3)
    """

    def __init__(self, first: Any, calibration: Any = None, **options: Any) -> None:
        native = None if calibration is None else calibration_of(calibration)
        sources, options = session_of(first, options)
        self._native = _gravical.Stepper(sources, native, keywords(options))

    def update(self, t: Any, accel: Any, gyro: Any = None, temperature: Any = None) -> States:
        """Take one sample: the time in s from any origin, or None if samples are evenly spaced at the
        rate of ``first``; raw specific force and angular rate of shape (3,), in the units of ``first``,
        NaN for a value that is missing; temperature in °C."""
        one = [None if value is None else [value] for value in (t, accel, gyro, temperature)]
        return States(*(values[0] for values in self.extend(*one)))

    def extend(self, t: Any, accel: Any, gyro: Any = None, temperature: Any = None) -> States:
        """Take a chunk of samples: arrays of shape (n,) and (n, 3), as of :meth:`update`."""
        if (t is not None) != self._native.timed:
            what = "missing: the first recording has time stamps"
            if t is not None:
                what = "given, but the first recording has no time stamps"
            raise UsageError(f"t= is {what}", hint="give times for both or for none of them")
        xyz = vectors(accel, "accel")
        rows = np.full((len(xyz), 8), np.nan)
        rows[:, 1:4] = xyz
        if t is not None:
            rows[:, 0] = scalars(t, "t", len(xyz))
        if gyro is not None:
            rows[:, 4:7] = vectors(gyro, "gyro", len(xyz))
        if temperature is not None:
            rows[:, 7] = scalars(temperature, "temperature", len(xyz))
        states = split(self._native.update(rows), (*MOTION, ("taken", 1)))
        return States(**{name: states[name] for name in States._fields})

    def interrupt(self) -> None:
        """Something is missing here: what follows is not known before the next rest, and the
        position not any more."""
        self._native.interrupt()

    @property
    def samples(self) -> int:
        """Number of samples so far."""
        return int(self._native.samples)

    @property
    def findings(self) -> list[Record]:
        """What is odd about the first recording."""
        return list(parsed(self._native.findings()))
