"""Keywords of the functions, and the documents of results; written by tests/make_types.py."""

import datetime
import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict, Union

Path = Union[str, "os.PathLike[str]"]
Paths = Union[Path, Sequence[Path]]
Text = Union[str, Sequence[Any], Mapping[str, Any]]

class InspectOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    axes: Text | None
    columns: Text | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class CalibrateOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    altitude: float | None
    axes: Text | None
    columns: Text | None
    face_pose: Paths | None
    free_pose: Paths | None
    gravity: float | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    latitude: float | None
    method: Literal["joint", "ferraris"] | None
    pose_tilt: float | None
    prior: Literal["data-sheet", "off"] | None
    rate: float | None
    recorded: Union[str, datetime.date] | None
    sections: Path | None
    sensor: Union[str, int] | None
    sensor_id: str | None
    sensor_model: str | None
    thermal: Paths | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class ApplyOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    axes: Text | None
    columns: Text | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    keep_raw: bool | None
    output_unit: Literal["m/s2", "m/s^2", "mps2", "g"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class DenoiseOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    columns: Text | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class NoiseOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    columns: Text | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class CheckOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    altitude: float | None
    axes: Text | None
    columns: Text | None
    gravity: float | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    latitude: float | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class MotionOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    altitude: float | None
    axes: Text | None
    columns: Text | None
    gravity: float | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    latitude: float | None
    no_stances: bool | None
    procedure: Literal["strapdown", "constant-tilt", "report"] | None
    rate: float | None
    rests: Text | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class OrientOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    acceleration: bool | None
    altitude: float | None
    axes: Text | None
    columns: Text | None
    gravity: float | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    latitude: float | None
    no_stances: bool | None
    procedure: Literal["strapdown", "constant-tilt", "report"] | None
    rate: float | None
    rests: Text | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class SimulateOptions(TypedDict, total=False):
    continuous: bool | None
    decimals: int | None
    distance: float | None
    drop: float | None
    duration: float | None
    free: int | None
    gravity: float | None
    hold: float | None
    jitter: float | None
    move_time: float | None
    noise: float | None
    range: int | None
    rate: float | None
    raw: bool | None
    rest: float | None
    scale_sd: float | None
    seed: int | None
    temperature_drift: float | None
    temperature_rise: float | None
    tilt: float | None
    wrong_header: bool | None

class ReadOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    columns: Text | None
    gyro: Path | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

class SamplesOptions(TypedDict, total=False):
    accel_range: float | None
    accel_unit: Literal["m/s2", "m/s^2", "mps2", "g", "mg", "counts"] | None
    columns: Text | None
    gyro_range: float | None
    gyro_unit: Literal["rad/s", "deg/s", "dps", "counts"] | None
    rate: float | None
    sensor: Union[str, int] | None
    time_unit: Literal["s", "ms", "us", "ns", "min", "h", "d"] | None
    zero_offset: float | None

AccelUnit = Literal["m/s^2"] | Literal["g"] | Literal["mg"] | Literal["counts"] | Literal["unknown"]

class Accelerometer(TypedDict):
    bias: list[float]
    covariance: Covariance | None
    input_unit: AccelUnit
    matrix: list[list[float]]
    method: Method
    nominal_scale: float | None
    nonlinearity: list[float] | None
    scale: list[float]
    orientation: list[list[float]]
    deviations: Deviations | None

class Advice(TypedDict):
    name: str
    value: str

class Budget(TypedDict):
    contributions: list[Contribution]

class ChannelDrift(TypedDict):
    channel: str
    input_unit: str
    per_c: float | None
    r2_cooling_to_warming: float | None
    r2_warming_to_cooling: float | None
    reason: str
    verdict: DriftVerdict

class Contribution(TypedDict):
    norm_mps2: float | None
    source: Source

class Covariance(TypedDict):
    parameters: list[str]
    values: list[list[float]]

DriftVerdict = Literal["corrected"] | Literal["not-corrected"]

class Explained(TypedDict):
    difference_mps2: float
    direction: list[float]
    probability: float

class Finding(TypedDict):
    count: int
    file: str | None
    gate: bool
    kind: str
    lines: list[list[int]]
    message: str
    options: list[Advice]
    severity: Severity
    values: dict[str, Any]

class FitQuality(TypedDict):
    chi2_per_freedom: float | None
    freedom: float
    model_error_mps2: float
    oriented: bool
    prior: bool
    tilt_degrees_of_freedom: float

GravitySource = Literal["given"] | Literal["latitude"] | Literal["standard"]

GyroMethod = Literal["turns"] | Literal["motion"] | Literal["bias"]

GyroUnit = Literal["rad/s"] | Literal["deg/s"] | Literal["counts"] | Literal["unknown"]

class Gyroscope(TypedDict):
    bias: list[float]
    covariance: Covariance | None
    g_sensitivity: list[list[float]]
    input_unit: GyroUnit
    left_out_deg: float | None
    matrix: list[list[float]]
    method: GyroMethod
    motions: MotionCounts | None
    residual_deg: float | None

class InputFile(TypedDict):
    path: str
    role: InputRole
    sha256: str | None

InputRole = Literal["recording"] | Literal["gyroscope"] | Literal["sections"] | Literal["soak"] | Literal["calibration"] | Literal["noise"] | Literal["other"]

Method = Literal["joint"] | Literal["ferraris"] | Literal["unknown"]

class MotionCounts(TypedDict):
    left_out: int
    used: int

class NextPose(TypedDict):
    direction: list[float]
    predicted_mps2: float
    undetected_effect_mps2: float | None
    worst_mps2: float | None

PoseKind = Literal["face"] | Literal["free"]

class PoseResult(TypedDict):
    calibrated: list[float]
    expected: list[float]
    fitted: bool
    kind: PoseKind
    label: str
    left_out_error_mps2: float | None
    left_out_sd_mps2: float | None
    lines: list[int] | None
    magnitude_error_mps2: float | None
    raw: list[float]
    rows: int
    source: str
    tilt_deg: float | None
    tilt_sd_deg: float | None

class PoseTilt(TypedDict):
    source: TiltSource
    value: float

class RecordingTime(TypedDict):
    time: UtcTime

class Reliability(TypedDict):
    budget: Budget | None
    explanations: list[Explained]
    fit: FitQuality | None
    left_out_rms_mps2: float | None
    next_poses: list[NextPose]
    pose_tilt_deg: PoseTilt | None
    predicted_mps2: float | None
    undetected: Undetected | None
    worst_direction: WorstDirection | None

class SensorInfo(TypedDict):
    id: str | None
    model: str | None

Severity = Literal["note"] | Literal["warning"]

Source = Literal["noise"] | Literal["quantisation"] | Literal["model-error"] | Literal["nonlinearity"] | Literal["pose-tilt"] | Literal["data-sheet"] | Literal["noise-and-tilt"] | Literal["local-gravity"] | Literal["temperature"]

class TemperatureModel(TypedDict):
    channels: list[ChannelDrift]
    range_c: list[float]
    reference_c: float

class TemperatureRange(TypedDict):
    max: float
    mean: float
    min: float

TiltSource = Literal["given"] | Literal["estimated"] | Literal["assumed"]

class Undetected(TypedDict):
    direction: list[float]
    effect_mps2: float
    pose: int
    reading_mps2: float

UtcTime = str

class WorstDirection(TypedDict):
    direction: list[float]
    error_mps2: float
    sd_mps2: float

class CalibrationDocument(TypedDict):
    accelerometer: Accelerometer
    command: str | None
    created: str
    drift: TemperatureModel | None
    findings: list[Finding]
    format: str
    gravity_mps2: float
    gravity_sd_mps2: float
    gravity_source: GravitySource
    gyroscope: Gyroscope | None
    inputs: list[InputFile]
    poses: list[PoseResult]
    recorded: RecordingTime | None
    reliability: Reliability
    sensor: SensorInfo
    temperature_c: TemperatureRange | None
    tool: str
    verdict: Verdict

class AllanPoint(TypedDict):
    edf: float
    high: float
    low: float
    sigma: float
    tau_s: float

class ChannelNoise(TypedDict):
    adev: list[AllanPoint]
    b: Estimate | None
    channel: str
    fit: FittedCurve | None
    k: Estimate | None
    n: Estimate | None
    not_observable: list[NotObservable]
    unit: str

class Drift(TypedDict):
    change: float
    during_s: float
    time_constant_s: float | None

class Estimate(TypedDict):
    high: float
    low: float
    value: float

class FittedCurve(TypedDict):
    drift: Drift | None
    from_s: float
    low_pass_hz: float | None
    misfit: Misfit | None
    parameters: list[float]

class Misfit(TypedDict):
    ratio: float
    tau_s: float

class NotObservable(TypedDict):
    at_most: float | None
    reason: str
    record_s: float | None
    term: str

class NoiseDocument(TypedDict):
    channels: list[ChannelNoise]
    description: str
    findings: list[Finding]
    format: str
    inputs: list[InputFile]
    rate_hz: float
    recorded_s: float
    segments: int
    static_intervals: int
    temperature_c: list[float] | None
    tool: str
    used_s: float

class Deviations(TypedDict):
    bias: list[float]
    scale: list[float]
    axis_angle_deg: list[float]

class Verdict(TypedDict):
    grade: Literal["good", "fair", "not-verifiable", "poor"]
    reasons: list[str]
