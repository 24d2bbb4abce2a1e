"""What a notebook needs: arrays in and out, a table of the result, figures on axes, pickles by path."""

from __future__ import annotations

import pickle
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gravical
import numpy as np
import pytest


class Axes:
    """Takes down what is drawn."""

    def __init__(self) -> None:
        self.drawn: list[str] = []

    def __getattr__(self, name: str) -> Any:
        def draw(*_: Any, **__: Any) -> Any:
            self.drawn.append(name)
            return [SimpleNamespace(get_color=lambda: "k")]

        return draw


@pytest.fixture(scope="module")
def poses() -> gravical.Recording:
    recording: gravical.Recording = gravical.simulate("poses", free=8, seed=3).recordings["poses.csv"]
    return recording


def test_arrays_go_in_and_come_out(poses: gravical.Recording) -> None:
    assert poses.gyro is not None
    for array in (poses.accel, np.hstack([poses.accel, poses.gyro])):
        calibration = gravical.calibrate(array, rate=100, accel_unit="m/s^2", gyro_unit="rad/s")
        assert (calibration.gyroscope is None) == (array.shape[1] == 3)
        assert calibration.bias.shape == (3,) and calibration.matrix.shape == (3, 3)
        assert np.array_equal(calibration.bias, calibration.accelerometer.bias)
    with pytest.raises(gravical.UsageError, match="shape"):
        gravical.calibrate(np.zeros((10, 4)), rate=100)


def test_a_notebook_shows_what_matters(poses: gravical.Recording) -> None:
    calibration = gravical.calibrate(poses, gravity=9.80665)
    page = calibration._repr_html_()
    for part in ("bias (m/s^2) x", " ± ", " mg</td>", "<img", "good: "):
        assert part in page
    found = gravical.inspect(poses)._repr_html_()
    for part in ("<th>rate_hz</th><td>100<", "<th>accelerometer</th><td>m/s^2<"):
        assert part in found
    for result in (calibration, poses, gravical.motion(gravical.simulate("line").recordings["line.csv"])):
        axes = Axes()
        assert result.plot(axes) is axes and "set" in axes.drawn
        assert not [name for name in dir(result) if name[0] == "_" and name[:2] != "__"]
    assert sorted(dir(gravical)) == sorted(gravical.__all__)


def test_a_recording_is_pickled_by_its_path(poses: gravical.Recording, tmp_path: Path) -> None:
    gravical.simulate("static", output=tmp_path)
    recording = gravical.read(tmp_path / "static.csv", accel_unit="g")
    again = pickle.loads(pickle.dumps(recording))
    assert (again.name, again.accel_unit) == (recording.name, "g")
    assert np.array_equal(again.accel, recording.accel)
    with pytest.raises(gravical.UsageError, match="no path"):
        pickle.dumps(poses)
