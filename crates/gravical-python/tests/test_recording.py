"""Recordings: arrays that share memory, tables of other libraries, pickles."""

from __future__ import annotations

import gc
import io
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pandas as pd
import polars as pl
import pytest


def test_arrays_are_views_that_live_on(line: gravical.Recording) -> None:
    ax = line.ax
    assert np.shares_memory(ax, line["ax"]) and np.shares_memory(ax, line.columns["ax"])
    assert not ax.flags.writeable and not ax.flags.owndata
    with pytest.raises(ValueError):
        ax[0] = 1.0
    with pytest.raises(ValueError):
        ax.flags.writeable = True
    with pytest.raises(KeyError):
        line["mx"]
    moved = gravical.motion(line)
    assert moved.position.shape == (1200, 3) and not moved.position.flags.writeable
    assert np.shares_memory(moved.position, moved.position)
    own = gravical.simulate("static", duration=5).recordings["static.csv"]
    views = [own.az, moved.position]
    copies = [view.copy() for view in views]
    del own, moved
    gc.collect()
    [np.zeros(size) for size in (500, 3600) for _ in range(100)]
    for view, copy in zip(views, copies):
        assert np.array_equal(view, copy)


@pytest.mark.parametrize(
    "change",
    [
        lambda a: np.asfortranarray(a),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[:, ::-1][:, ::-1],
        lambda a: tuple(a.T),
        lambda a: a.astype(object),
        lambda a: a.tolist(),
        lambda a: a.astype(">f8"),
    ],
)
def test_any_layout_of_memory_gives_the_same(
    change: Callable[[Any], Any], line: gravical.Recording
) -> None:
    own = gravical.Recording.from_arrays(t=line.t, accel=change(line.accel))
    assert np.array_equal(own.ax, line.ax) and np.array_equal(own.az, line.az)
    assert own.accel_unit == "m/s^2"


def test_what_is_not_a_number_is_missing(line: gravical.Recording) -> None:
    accel = line.accel
    accel[100] = np.nan
    accel[200] = np.inf
    own = gravical.Recording.from_arrays(t=line.t, accel=accel)
    assert np.isnan(own.ax[[100, 200]]).all()
    assert "empty-cells" in [finding.kind for finding in own.findings]


def tables(recording: gravical.Recording) -> dict[str, Any]:
    assert recording.t is not None
    columns = {
        "Timestamp (ms)": 1000 * recording.t,
        "acc_x": recording.ax,
        "acc_y": recording.ay,
        "acc_z": recording.az,
        "gyr_x": recording.gx,
        "gyr_y": recording.gy,
        "gyr_z": recording.gz,
        "note": ["as it was"] * len(recording),
    }
    return {
        "dict": columns,
        "pandas": pd.DataFrame(columns),
        "polars": pl.DataFrame(columns),
    }


@pytest.mark.parametrize("kind", ["dict", "pandas", "polars"])
def test_tables_are_recordings(
    kind: str, line: gravical.Recording, calibration: gravical.Calibration
) -> None:
    table = tables(line)[kind]
    own = gravical.read(table)
    assert np.array_equal(own.ay, line.ay) and own.gyro is not None
    assert own.rate_hz == pytest.approx(line.rate_hz, rel=1e-6)
    applied = gravical.apply(calibration, table, gyro_unit="rad/s")
    expected = gravical.apply(calibration, line)
    assert np.allclose(applied.accel, expected.accel, rtol=0, atol=1e-12)
    assert list(applied.to_pandas()) == ["t_s", *expected.columns]


def test_out_to_pandas_and_polars(line: gravical.Recording) -> None:
    assert list(line.to_pandas()) == pl.DataFrame(line.columns).columns == list(line.columns)


def test_dates_are_times() -> None:
    z = np.tile([0.0, 0.0, 9.81], (200, 1))
    stamps = np.datetime64("2026-03-01T10:00:00") + np.arange(200) * np.timedelta64(20, "ms")
    own = gravical.Recording.from_arrays(t=stamps, accel=z)
    assert own.rate_hz == pytest.approx(50.0)
    assert own.recorded is not None and own.recorded.startswith("2026-03-01T10:00:00")
    index = pd.DatetimeIndex(stamps, tz="Europe/Berlin")
    frame = pd.DataFrame(z, columns=["ax", "ay", "az"], index=index)
    assert gravical.read(frame).rate_hz == pytest.approx(50.0)
    frame = pd.DataFrame({"time": stamps, "ax": z[:, 0], "ay": z[:, 1], "az": z[:, 2]})
    assert gravical.read(frame).rate_hz == pytest.approx(50.0)
    assert gravical.read(pl.DataFrame(frame)).rate_hz == pytest.approx(50.0)


def test_missing_values_of_pandas() -> None:
    frame = pd.DataFrame({"ax": [0, 1] * 50, "ay": [0, 1] * 50, "az": [8192] * 100})
    frame = frame.astype("Int64")
    frame.loc[10, "az"] = pd.NA
    own = gravical.read(frame, rate=100)
    assert np.isnan(own.az[10]) and own.az[11] == 8192.0


def test_labels_of_a_table_are_poses(poses: gravical.Recording) -> None:
    means = {
        "+x": (10.20, -0.04, -0.10), "-x": (-9.43, -0.27, 0.92), "+y": (0.29, 9.73, 0.49),
        "-y": (0.46, -9.99, 0.39), "+z": (0.83, -0.18, 10.42), "-z": (-0.05, -0.08, -9.54),
    }  # fmt: skip
    frame = pd.DataFrame([(k, *v) for k, v in means.items()], columns=["label", "ax", "ay", "az"])
    own = gravical.read(frame)
    assert own.labels == list(means)
    calibration = gravical.calibrate(frame, gravity=9.81, method="ferraris")
    assert calibration.accelerometer.bias[0] == pytest.approx(0.385, abs=1e-12)
    by_pose = {name: np.tile(mean, (50, 1)) for name, mean in means.items()}
    again = gravical.calibrate(by_pose, gravity=9.81, method="ferraris", rate=100)
    assert np.allclose(again.accelerometer.bias, calibration.accelerometer.bias, rtol=0, atol=1e-9)


def test_bytes_and_files(examples: Path) -> None:
    path = examples / "demo/line/line.csv"
    own = gravical.read(path)
    assert np.array_equal(gravical.read(path.read_bytes()).ax, own.ax)
    with path.open("rb") as file:
        assert np.array_equal(gravical.read(file).ax, own.ax)
    assert gravical.read(io.BytesIO(path.read_bytes()), name="here").name == "here"


def test_pickles_are_the_same(
    line: gravical.Recording, calibration: gravical.Calibration
) -> None:
    loaded = pickle.loads(pickle.dumps(calibration))
    assert loaded == calibration and loaded.apply([0, 0, 9.8]).shape == (3,)
    moved = gravical.motion(line, calibration)
    kept = pickle.loads(pickle.dumps(moved))
    assert kept == moved and str(kept) == str(moved) and kept.verdict.judgement == "usable"
    assert np.array_equal(kept.position, moved.position, equal_nan=True)
    assert np.array_equal(kept.still, moved.still)
    # Figures and reports are left behind.
    assert "<img" in moved._repr_html_() and "<img" not in kept._repr_html_()
    with pytest.raises(gravical.UsageError):
        kept.report()
    with pytest.raises(gravical.NotFoundError) as missing:
        gravical.read("no-such-file.csv")
    error = pickle.loads(pickle.dumps(missing.value))
    assert isinstance(error, gravical.NotFoundError) and str(error) == str(missing.value)
    assert error.code == "not-found" and error.file == "no-such-file.csv"
