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

from ._errors import Error, ExistsError, InputError, MachineError, NotFoundError, UsageError
from ._gravical import __version__
from ._recording import Recording, read
from ._result import Calibration, ExportWarning, Figure, Record, Result
from ._verbs import (
    apply,
    calibrate,
    check,
    compare,
    denoise,
    export_targets,
    inspect,
    motion,
    noise,
    simulate,
)

__all__ = [
    "Calibration",
    "Error",
    "ExistsError",
    "ExportWarning",
    "Figure",
    "InputError",
    "MachineError",
    "NotFoundError",
    "Record",
    "Recording",
    "Result",
    "UsageError",
    "__version__",
    "apply",
    "calibrate",
    "check",
    "compare",
    "denoise",
    "export_targets",
    "inspect",
    "motion",
    "noise",
    "read",
    "simulate",
]
