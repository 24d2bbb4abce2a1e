"""Keywords of the functions, written by tests/make_types.py."""

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
