"""gravical: turn a cheap IMU into an instrument you can trust.

The functions are the commands of the program, their arguments its options, and their numbers its
numbers, to the last bit.

>>> import gravical
>>> session = gravical.simulate("poses", free=8, seed=3)
>>> calibration = gravical.calibrate(session.recordings, gravity=9.80665)
>>> str(calibration.verdict)
'good'

Errors are exceptions (:class:`Error`) with a ``code`` and a ``hint``; what is odd but no error is
in the ``findings`` of a result.
"""

from __future__ import annotations

from ._arrays import (
    AllanDeviation,
    allan,
    allan_deviation,
    filtered,
)
from ._calibration import Calibration, ExportWarning, calibrate, export_targets
from ._errors import (
    Error,
    ExistsError,
    InputError,
    MachineError,
    NotFoundError,
    UsageError,
)
from ._findings import Finding, Verdict
from ._gravical import __version__
from ._motion import Motion, MotionOptions, MotionResult, State, States, motion
from ._recording import Recording, read
from ._results import (
    ApplySummary,
    CheckReport,
    Comparison,
    Figure,
    Inspection,
    NoiseResult,
    Result,
)
from ._types import Reading
from ._verbs import (
    Applied,
    Denoised,
    Simulation,
    apply,
    check,
    compare,
    denoise,
    inspect,
    noise,
    simulate,
)

__all__ = [
    "AllanDeviation",
    "Applied",
    "ApplySummary",
    "Calibration",
    "CheckReport",
    "Comparison",
    "Denoised",
    "Error",
    "ExistsError",
    "ExportWarning",
    "Figure",
    "Finding",
    "InputError",
    "Inspection",
    "MachineError",
    "Motion",
    "MotionOptions",
    "MotionResult",
    "NoiseResult",
    "NotFoundError",
    "Reading",
    "Recording",
    "Result",
    "Simulation",
    "State",
    "States",
    "UsageError",
    "Verdict",
    "__version__",
    "allan",
    "allan_deviation",
    "apply",
    "calibrate",
    "check",
    "compare",
    "denoise",
    "export_targets",
    "filtered",
    "inspect",
    "motion",
    "noise",
    "read",
    "simulate",
]
