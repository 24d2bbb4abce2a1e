"""The numbers of the program, to the last bit, for every verb on every example."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pytest

from conftest import Program

#: What differs from run to run: when, and by which command.
VARIES = ("created", "command")

#: Sessions of the repository and of the real recordings, with the options that they need.
SESSIONS: list[tuple[str, dict[str, Any]]] = [
    ("examples/simulated-six-position", {"gravity": 9.80665}),
    ("examples/demo/poses", {"latitude": 48.1, "altitude": 500}),
    ("examples/report-six-means.csv", {"gravity": 9.81, "method": "ferraris"}),
    ("examples/demo/poses", {"prior": "off", "axes": "y,-x,z"}),
]
DATA_SESSIONS: list[tuple[str, dict[str, Any]]] = [
    ("imucal-ferraris/annotated_session.csv", {"rate": 204.8, "gravity": 9.81}),
    ("imucal-ferraris/example_ferraris_session.csv", {"rate": 102.4}),
    ("tomisuarez-mpu6050/calibration.csv", {"latitude": -34.6}),
    ("mikoff-mpu9150/imu0.log", {"rate": 100}),
    ("imu_tk-xsens/xsens_acc.txt.gz", {"gravity": 9.81744}),
    ("airbrakes-sixmoves", {}),
]
RECORDINGS = [
    "examples/demo/line/line.csv",
    "examples/demo/poses/poses.csv",
    "examples/simulated-six-position/x_axis_pos.csv",
    "examples/report-six-means.csv",
]
DATA_RECORDINGS = [
    "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz",
    "pabrod-elevator/skyscrapper_up.csv",
    "xio-gait/short_walk.csv",
    "bennyhui-phone/Accelerometer.csv",
    "tomisuarez-mpu6050/calibration.csv",
    "ggir-stills/stills_10s.csv.gz",
    "opensim-imu/apdm_imuData01.csv.gz",
]


def flags(options: dict[str, Any]) -> list[str]:
    words = []
    for name, value in options.items():
        text = ",".join(map(str, value)) if isinstance(value, tuple) else value
        words.append(f"--{name.replace('_', '-')}" + ("" if value is True else f"={text}"))
    return words


def alike(a: Any, b: Any, place: str = "") -> None:
    """Equal, every number to the last bit; a failure names the first place that is not."""
    if isinstance(a, dict) and isinstance(b, dict):
        assert a.keys() - set(VARIES) == b.keys() - set(VARIES), place
        for key in a.keys() - set(VARIES):
            alike(a[key], b[key], f"{place}.{key}")
    elif isinstance(a, list) and isinstance(b, list):
        assert len(a) == len(b), place
        for i, (one, other) in enumerate(zip(a, b)):
            alike(one, other, f"{place}[{i}]")
    else:
        assert a == b and type(a) is type(b), f"{place}: {a!r} {b!r}"


def both(call: Any, theirs: dict[str, Any]) -> None:
    """The same result, or the same error."""
    try:
        own = call()
    except gravical.Error as error:
        assert error.code == theirs.get("code"), (error, theirs)
    else:
        alike(own, theirs)


def table_of(path: Path) -> tuple[list[str], Any]:
    """Names and columns of a table, NaN for what is no number."""
    names = path.read_text().splitlines()[0].split(",")
    return names, np.genfromtxt(path, delimiter=",", skip_header=1)


@pytest.fixture
def path(name: str, request: pytest.FixtureRequest) -> str:
    if name.startswith("examples"):
        return name
    return str(request.getfixturevalue("data") / name)


@pytest.fixture(autouse=True)
def in_root(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names of files are those that the program is given."""
    monkeypatch.chdir(root)


@pytest.mark.parametrize(("name", "options"), SESSIONS + DATA_SESSIONS)
def test_calibrate_and_check(
    path: str, options: dict[str, Any], program: Program, tmp_path: Path
) -> None:
    theirs = program("calibrate", path, "--json", *flags(options))
    both(lambda: gravical.calibrate(path, **options), theirs)
    if "code" in theirs:
        return
    # Saved, it is the file of the program; a check of it is the program's.
    file = tmp_path / "cal.json"
    gravical.calibrate(path, **options).save(file)
    program("calibrate", path, "-o", tmp_path / "own.json", *flags(options), parse=False)
    alike(json.loads(file.read_text()), json.loads((tmp_path / "own.json").read_text()))
    reading = {k: v for k, v in options.items() if k in ("rate", "axes", "gravity")}
    theirs = program("check", file, path, "--json", *flags(reading))
    both(lambda: gravical.check(file, path, **reading), theirs)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_inspect(path: str, program: Program) -> None:
    theirs = program("inspect", path, "--json")
    both(lambda: gravical.inspect(path), (theirs["recordings"] or theirs["errors"])[0])


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_motion(path: str, program: Program) -> None:
    theirs = program("motion", path, "--json", "--quiet")
    both(lambda: gravical.motion(path), theirs)


@pytest.mark.parametrize("verb", ["motion", "orient"])
def test_motion_with_a_calibration_and_its_table(
    verb: str, program: Program, calibration: gravical.Calibration, tmp_path: Path
) -> None:
    cal, table = tmp_path / "cal.json", tmp_path / "track.csv"
    calibration.save(cal)
    line = gravical.simulate("line", seed=3, output=tmp_path / "line").paths[0]
    theirs = program(verb, line, "-c", cal, "--json", "--quiet", "-o", table)
    own = getattr(gravical, verb)(line, cal)
    alike(own, theirs)
    own.save(tmp_path / "own.csv")
    assert (tmp_path / "own.csv").read_bytes() == table.read_bytes()
    names, written = table_of(table)
    frame = own.to_pandas()
    assert list(frame) == names
    assert np.allclose(frame.to_numpy(dtype=float), written, rtol=0, atol=1e-6, equal_nan=True)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS[:5])
def test_noise(path: str, program: Program, tmp_path: Path) -> None:
    words = ["--json", "-q", "-o", tmp_path / "noise.json"]
    theirs = program("noise", path, *words)
    both(lambda: gravical.noise(path), theirs)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_denoise(path: str, program: Program, tmp_path: Path) -> None:
    filters = ["hampel:7,3", "butter:4,5Hz"]
    words = ["-f", filters[0], "-f", filters[1], "--json", "-q", "-o", tmp_path / "a.csv"]
    theirs = program("denoise", path, *words)
    # What is read of a file, and how, is of the program.
    shown = theirs if "code" in theirs else {"filters": theirs["filters"]}
    both(lambda: {"filters": gravical.denoise(path, filters).filters}, shown)


@pytest.mark.parametrize("name", ["examples/demo/line/line.csv", "examples/demo/poses/poses.csv"])
@pytest.mark.parametrize("unit", ["m/s^2", "g"])
def test_apply(
    path: str, unit: Any, program: Program, calibration: gravical.Calibration, tmp_path: Path
) -> None:
    cal, a, b = tmp_path / "cal.json", tmp_path / "a.csv", tmp_path / "b.csv"
    calibration.save(cal)
    theirs = program("apply", cal, path, "-o", a, "--json", "-q", "--output-unit", unit)
    assert theirs.pop("calibration") == str(cal)
    alike(gravical.apply(cal, path, output=b, output_unit=unit), theirs)
    assert a.read_bytes() == b.read_bytes()
    # In memory: the same before it is rounded to six decimals.
    names, written = table_of(a)
    for column, values in gravical.apply(cal, path, output_unit=unit).to_pandas().items():
        if column == "t_s":
            continue
        assert np.abs(values - written[:, names.index(column)]).max() <= 0.5e-6 + 1e-12, column


def test_compare(program: Program, calibration: gravical.Calibration, tmp_path: Path) -> None:
    a, b = tmp_path / "a.json", tmp_path / "b.json"
    calibration.save(a)
    gravical.calibrate("examples/demo/poses").save(b)
    alike(gravical.compare(a, b), program("compare", a, b, "--json"))


@pytest.mark.parametrize(
    ("scenario", "options"),
    [
        ("six-position", {"seed": 7, "hold": 3.0, "raw": True}),
        ("six-position", {"continuous": True, "rate": 50.0}),
        ("poses", {"free": 3, "tilt": 0.5, "noise": 2.0, "decimals": 6}),
        ("static", {"duration": 20.0, "temperature_drift": 2.0, "rate": 20.0}),
        ("line", {"distance": -0.3, "jitter": 1.0, "drop": 0.05, "wrong_header": True}),
    ],
)
def test_simulate(
    scenario: Any, options: dict[str, Any], program: Program, tmp_path: Path
) -> None:
    theirs = program("simulate", scenario, "-o", tmp_path / "a", "--json", "-q", *flags(options))
    made = gravical.simulate(scenario, output=tmp_path / "b", **options)
    alike(made, theirs)
    for name in os.listdir(tmp_path / "a"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    # Without files: the same recordings.
    again = gravical.simulate(scenario, **options)
    for name, recording in made.recordings.items():
        assert np.array_equal(again.recordings[name].ax, recording.ax, equal_nan=True)


@pytest.mark.parametrize("to", list(gravical.export_targets()))
def test_export(to: str, program: Program, calibration: gravical.Calibration, tmp_path: Path) -> None:
    cal = tmp_path / "cal.json"
    calibration.save(cal)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gravical.ExportWarning)
        try:
            own = calibration.export(to)
        except gravical.Error as error:
            assert to in ("kalibr", "ros-noise"), error
            assert error.hint and "gravical noise" in error.hint
            return
    theirs = program("export", cal, "--to", to, parse=False)

    def without_date(text: str) -> list[str]:
        return [line for line in text.splitlines() if "created" not in line]

    assert without_date(own) == without_date(theirs)
