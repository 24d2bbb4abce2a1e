"""Calibrations: what they hold, what is written, what is shown."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pytest


def test_the_truth_is_within_the_uncertainty(calibration: gravical.Calibration) -> None:
    truth = gravical.simulate("poses", free=8, seed=3).truth["accelerometer"]
    covariance = calibration.covariance
    assert covariance is not None and covariance.shape == (18, 18)
    names = calibration.covariance_parameters
    sd = np.sqrt(np.diag(covariance))[[names.index(f"bias_{axis}") for axis in "xyz"]]
    assert (np.abs(calibration.bias - truth["bias_mps2"]) < 4 * sd).all()


def test_apply_is_matrix_times_raw_less_bias(
    calibration: gravical.Calibration, line: gravical.Recording
) -> None:
    raw = line.accel
    expected = (raw - calibration.bias) @ calibration.matrix.T
    own = calibration.apply(raw)
    assert np.allclose(own, expected, rtol=0, atol=1e-12)
    assert np.array_equal(calibration.apply(np.asfortranarray(raw)), own)
    assert np.array_equal(calibration.apply(raw[::3]), own[::3])
    assert np.array_equal(calibration.apply(raw[0]), own[0])
    assert np.array_equal(gravical.apply(calibration, line).accel, own)
    assert calibration.apply(np.empty((0, 3))).shape == (0, 3)
    assert np.isnan(calibration.apply([[np.nan, 0, 0]])).all()
    gyro = line.gyro
    assert gyro is not None
    rates = calibration.apply_gyro(gyro, own)
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


def test_reports_and_figures(calibration: gravical.Calibration, tmp_path: Path) -> None:
    calibration.report(tmp_path / "cal.html")
    page = (tmp_path / "cal.html").read_text()
    assert page.startswith("<!DOCTYPE html>") and "<svg" in page
    assert calibration.report(tmp_path / "cal.md").startswith("# ")
    assert len(calibration.figures) > 2
    for figure in calibration.figures:
        assert figure.svg.startswith("<svg") and figure.title and figure._repr_svg_()
    shown = calibration._repr_html_()
    assert shown.count("<img") == len(calibration.figures) and "<script" not in shown
    assert "good" in shown and str(calibration).startswith("Calibration of poses.csv")


def test_a_poor_result_is_no_exception(poses: gravical.Recording) -> None:
    six = gravical.simulate("six-position", seed=2, hold=2.0)
    calibration = gravical.calibrate(six.recordings)
    assert calibration.verdict == "not-verifiable" and calibration.verdict.reasons
    assert gravical.check(calibration, poses).verdict in ("fits", "does-not-fit", "undecided")


def test_findings_name_kind_and_file() -> None:
    made = gravical.simulate("six-position", seed=2, hold=2.0, wrong_header=True)
    finding = {finding.kind: finding for finding in made.findings}["unit-mismatch"]
    assert finding.is_warning and finding.file and str(finding).startswith("unit-mismatch: ")


def test_exports(calibration: gravical.Calibration) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        text = calibration.export("ros")
    assert "SM:" in text or "matrix" in text.lower()
    assert all(issubclass(w.category, gravical.ExportWarning) for w in caught)
    with pytest.raises(gravical.UsageError) as error:
        calibration.export("excel")
    assert "imucal" in (error.value.hint or "") and "to=" in error.value.message


def test_imucal_in_and_out(calibration: gravical.Calibration, line: gravical.Recording) -> None:
    imucal = pytest.importorskip("imucal")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        theirs: Any = calibration.to_imucal()
    assert isinstance(theirs, imucal.CalibrationInfo)
    gyro = line.gyro
    assert gyro is not None
    accel, rate = theirs.calibrate(line.accel, gyro, "m/s^2", "rad/s")
    own = gravical.apply(calibration, line)
    assert np.allclose(accel, own.accel, rtol=0, atol=1e-9)
    back = gravical.Calibration.from_imucal(theirs)
    assert np.allclose(back.bias, calibration.bias, rtol=0, atol=1e-12)
    assert np.allclose(back.apply(line.accel), own.accel, rtol=0, atol=1e-9)
    # It is a calibration wherever one is taken.
    assert gravical.compare(calibration, theirs).verdict == "undecided"


def test_noise_goes_into_a_calibration(poses: gravical.Recording, tmp_path: Path) -> None:
    rest = gravical.simulate("static", duration=120, seed=4).recordings["static.csv"]
    noise = gravical.noise(rest)
    noise.save(tmp_path / "noise.json")
    by_object = gravical.calibrate(poses, noise=noise).to_dict()
    by_path = gravical.calibrate(poses, noise=tmp_path / "noise.json").to_dict()
    assert by_object["noise"] == by_path["noise"] and by_object["noise"]["channels"]
    assert "accelerometer_noise_density" in noise.to_kalibr(upper_limit=True)


def test_arrays_are_filtered_as_recordings(line: gravical.Recording) -> None:
    for spec in ("savgol:11,2", "hampel:7,3", "butter:4,5Hz"):
        own = gravical.filtered(line.accel, spec, rate=100.0)
        theirs = gravical.denoise(line, spec).recording
        assert theirs is not None and own.shape == (1200, 3)
        assert np.allclose(own, theirs.accel, rtol=0, atol=1e-4), spec
        assert np.array_equal(gravical.filtered(line.ax, spec, rate=100.0), own[:, 0])
