"""Results: what they hold, what is written, what is shown."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pytest


def test_apply_is_matrix_times_raw_less_bias(
    calibration: gravical.Calibration, line: gravical.Recording
) -> None:
    raw, found = line.accel, calibration.accelerometer
    expected = (raw - np.array(found.bias)) @ np.array(found.matrix).T
    own = calibration.apply(raw)
    assert np.allclose(own, expected, rtol=0, atol=1e-12)
    assert np.array_equal(calibration.apply(raw[::3]), own[::3])
    assert np.array_equal(calibration.apply(raw[0]), own[0])
    assert np.array_equal(gravical.apply(calibration, line).accel, own)
    assert calibration.apply(np.empty((0, 3))).shape == (0, 3)
    assert np.isnan(calibration.apply([[np.nan, 0, 0]])).all()
    rates = calibration.apply_gyro(line.gyro, own)
    assert np.allclose(rates, gravical.apply(calibration, line).gyro, rtol=0, atol=1e-15)


def test_nothing_is_overwritten(calibration: gravical.Calibration, tmp_path: Path) -> None:
    path = tmp_path / "cal.json"
    calibration.save(path)
    before = path.read_bytes()
    with pytest.raises(gravical.ExistsError) as error:
        calibration.save(path)
    assert error.value.code == "exists" and "force" in str(error.value)
    assert isinstance(error.value, FileExistsError)
    assert path.read_bytes() == before
    calibration.save(path, force=True)
    assert gravical.Calibration.load(path) == calibration
    for write in (
        lambda: calibration.report(path),
        lambda: calibration.report(tmp_path / "a.html") and calibration.report(tmp_path / "a.html"),
        lambda: calibration.export("c", path),
        lambda: calibration.figures[0].save(path),
    ):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with pytest.raises(gravical.UsageError):
                write()
    assert not [p for p in tmp_path.iterdir() if p.name not in ("cal.json", "a.html")]


def test_a_result_cannot_be_changed(calibration: gravical.Calibration) -> None:
    def change(of: Any) -> None:
        of["verdict"] = 1

    parts: list[Any] = [calibration, calibration.verdict]
    for part in parts:
        with pytest.raises(TypeError, match="cannot be changed"):
            change(part)
        with pytest.raises(TypeError, match="cannot be changed"):
            part.grade = "good"
        with pytest.raises(AttributeError, match="there is no 'verdit' here"):
            part.verdit


def test_reports_and_figures(calibration: gravical.Calibration, tmp_path: Path) -> None:
    calibration.report(tmp_path / "cal.html")
    page = (tmp_path / "cal.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "<svg" in page
    assert len(calibration.figures) > 2
    for figure in calibration.figures:
        assert figure.svg.startswith("<svg") and figure.title and figure._repr_svg_()
    shown = calibration._repr_html_()
    assert shown.count("<img") == 1 and "<script" not in shown and "<th>verdict" in shown
    assert "good" in shown and str(calibration).startswith("Calibration of poses.csv")


def test_a_poor_result_is_no_exception() -> None:
    six = gravical.simulate("six-position", seed=2, hold=2.0)
    calibration = gravical.calibrate(six.recordings)
    assert calibration.verdict.grade == "not-verifiable" and calibration.verdict.reasons


def test_an_unknown_export_is_told(calibration: gravical.Calibration) -> None:
    with pytest.raises(gravical.UsageError) as error:
        calibration.export("excel")
    assert "imucal" in (error.value.hint or "") and "to=" in error.value.message


@pytest.mark.parametrize("raw", [False, True])
def test_imucal_in_and_out(raw: bool) -> None:
    imucal = pytest.importorskip("imucal")
    made = gravical.simulate("six-position", continuous=True, hold=4.0, seed=11, raw=raw)
    session = made.recordings["session.csv"]
    calibration = gravical.calibrate(session)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs: Any = imucal.CalibrationInfo.from_json(calibration.export("imucal"))
    units = (theirs.from_acc_unit, theirs.from_gyr_unit)
    accel, gyro = theirs.calibrate(session.accel, session.gyro, *units)
    own = gravical.apply(calibration, session)
    assert np.allclose(accel, own.accel, rtol=0, atol=1e-9 * np.abs(accel).max())
    # imucal gives °/s.
    assert np.allclose(gyro, np.degrees(own.gyro), rtol=0, atol=1e-9 * np.abs(gyro).max())
    if not raw:
        # It is a calibration wherever one is taken.
        assert np.allclose(gravical.apply(theirs, session).accel, own.accel, rtol=0, atol=1e-9)
        assert gravical.compare(calibration, theirs).verdict.judgement == "undecided"


def test_noise_is_exported() -> None:
    rest = gravical.simulate("static", duration=120, seed=4).recordings["static.csv"]
    noise = gravical.noise(rest)
    assert "accelerometer_noise_density" in noise.export("kalibr", upper_limit=True)
