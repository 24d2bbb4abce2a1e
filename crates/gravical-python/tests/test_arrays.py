"""Plain arrays: the closed form and the Allan deviation beside what else computes them."""

from __future__ import annotations

from typing import Any

import gravical
import numpy as np
import pytest

RATE = 100.0


def session(rows: int = 500) -> dict[str, np.ndarray[Any, Any]]:
    """Six faces and three turns, in m/s² and °/s, of a sensor that is off."""
    g = np.random.default_rng(4)
    model = np.array([[1.02, 0.01, 0.0], [-0.02, 0.98, 0.01], [0.0, 0.02, 1.01]])
    poses = {}
    for i, axis in enumerate("xyz"):
        for sign, name in ((9.81, "p"), (-9.81, "a")):
            a = np.hstack([np.tile(sign * model[:, i] + 0.1, (rows, 1)), np.full((rows, 3), 0.4)])
            poses[f"{axis}_{name}"] = a + g.normal(0, 0.01, a.shape)
        turn = np.hstack([np.tile(9.81 * model[:, 2] + 0.1, (rows, 1)), np.full((rows, 3), 0.4)])
        turn[:, 3:] -= 360.0 * RATE / rows * model[:, i]
        poses[f"{axis}_rot"] = turn + g.normal(0, 0.01, turn.shape)
    return poses


def test_the_closed_form_is_that_of_imucal() -> None:
    imucal = pytest.importorskip("imucal")
    poses = session()
    fields = {
        f"{sensor}_{name}": rows[:, part]
        for name, rows in poses.items()
        for sensor, part in (("acc", slice(0, 3)), ("gyr", slice(3, 6)))
    }
    regions = imucal.FerrarisSignalRegions(**fields)
    theirs = imucal.FerrarisCalibration(grav=9.81).compute(
        regions, RATE, from_acc_unit="m/s^2", from_gyr_unit="deg/s"
    )
    own = gravical.ferraris(poses, gravity=9.81, rate=RATE)
    assert own.gyro_bias is not None and own.gyro_matrix is not None
    assert np.allclose(own.bias, theirs.b_a, rtol=0, atol=1e-12)
    assert np.allclose(own.matrix, np.linalg.inv(theirs.K_a @ theirs.R_a), rtol=0, atol=1e-12)
    assert np.allclose(own.gyro_bias, theirs.b_g, rtol=0, atol=1e-12)
    # It takes the accelerometer's reading as it is for the effect on the gyroscope.
    in_deg = np.degrees(own.gyro_matrix)
    assert np.allclose(in_deg, np.linalg.inv(theirs.K_g @ theirs.R_g), rtol=0, atol=1e-4)


def test_the_closed_form_is_that_of_calibrate() -> None:
    poses = session()
    rows = np.concatenate(list(poses.values()))
    recording = gravical.Recording.from_arrays(
        t=np.arange(len(rows)) / RATE,
        accel=rows[:, :3],
        gyro=rows[:, 3:],
        labels=np.repeat(list(poses), [len(p) for p in poses.values()]),
        unit="m/s^2",
        gyro_unit="deg/s",
    )
    whole = gravical.calibrate(recording, method="ferraris", gravity=9.81)
    own = gravical.ferraris(poses, gravity=9.81, rate=RATE)
    for mine, theirs in (
        (own.bias, whole.bias),
        (own.matrix, whole.matrix),
        (own.gyro_bias, whole.gyro_bias),
        (own.gyro_matrix, whole.gyro_matrix),
    ):
        assert mine is not None and theirs is not None
        assert np.allclose(mine, theirs, rtol=1e-9, atol=1e-12)
    faces = {name: p[:, :3] for name, p in poses.items() if "rot" not in name}
    alone = gravical.ferraris(faces, gravity=9.81)
    assert np.array_equal(alone.matrix, own.matrix) and alone.gyro_matrix is None


def test_what_the_closed_form_cannot_take() -> None:
    poses = session(10)
    faces = {name: p for name, p in poses.items() if "rot" not in name}
    for given, code in (
        ({k: v for k, v in faces.items() if k != "y_a"}, "missing-face"),
        (faces | {"walking": poses["x_p"]}, "usage"),
        (faces | {"x_rot": poses["x_rot"]}, "singular"),
        (poses | {"x_rot": poses["x_rot"][:, :3]}, "missing-gyro"),
        (faces | {"x_p": poses["x_p"] * np.nan}, "singular"),
        (faces | {"x_p": poses["x_p"][:0]}, "missing-face"),
        (faces | {"x_p": poses["x_p"][:, :2]}, "usage"),
        ([], "usage"),
    ):
        with pytest.raises(gravical.Error) as error:
            gravical.ferraris(given, rate=RATE)  # type: ignore[arg-type]
        assert error.value.code == code, given
    with pytest.raises(gravical.UsageError) as error:
        gravical.ferraris(poses)
    assert error.value.code == "rate-unknown"


def test_the_allan_deviation_is_that_of_its_definition() -> None:
    samples = np.random.default_rng(6).normal(3, 1, 5000).cumsum()
    found = gravical.allan_deviation(samples, rate=50.0, taus=[0.02, 0.5, 20.0, 1e3, -1.0])
    assert found.tau.tolist() == [0.02, 0.5, 20.0]
    phases = np.concatenate([[0.0], samples.cumsum()])
    for tau, adev in zip(found.tau, found.adev):
        m = round(tau * 50)
        second = phases[2 * m :] - 2 * phases[m:-m] + phases[: -2 * m]
        assert np.isclose(adev, np.sqrt((second**2).mean() / 2) / m, rtol=1e-9)
    octaves = gravical.allan_deviation(samples, rate=50.0)
    points = gravical.allan(samples, rate=50.0, full=True)["adev"]
    assert np.allclose(octaves.adev[: len(points)], [p["sigma"] for p in points], rtol=1e-12)
    assert len(gravical.allan_deviation([], rate=50.0).tau) == 0
    with pytest.raises(gravical.UsageError):
        gravical.allan_deviation(samples, rate=50.0, taus="a")  # type: ignore[arg-type]
