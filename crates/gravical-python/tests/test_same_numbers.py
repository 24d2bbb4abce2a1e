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
]
DATA_RECORDINGS = [
    "broad-translation/14_undisturbed_slow_translation_with_breaks_B.csv.gz",
    "pabrod-elevator/skyscrapper_up.csv",
    "xio-gait/short_walk.csv",
    "bennyhui-phone/Accelerometer.csv",
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


@pytest.mark.parametrize(
    ("verb", "options"), [("inspect", {}), ("motion", {}), ("motion", {"causal": True}), ("noise", {})]
)
@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_a_recording(
    path: str, verb: str, options: dict[str, Any], program: Program, tmp_path: Path
) -> None:
    words = {"motion": ["-q"], "noise": ["-q", "-o", tmp_path / "noise.json"]}.get(verb, [])
    theirs = program(verb, path, "--json", *words, *flags(options))
    if verb == "inspect":
        theirs = (theirs["recordings"] or theirs["errors"])[0]
    both(lambda: getattr(gravical, verb)(path, **options), theirs)


def test_motion_with_a_calibration_and_its_table(
    program: Program, calibration: gravical.Calibration, tmp_path: Path
) -> None:
    cal, table = tmp_path / "cal.json", tmp_path / "track.csv"
    calibration.save(cal)
    line = gravical.simulate("line", seed=3, output=tmp_path / "line").paths[0]
    theirs = program("motion", line, "-c", cal, "--json", "--quiet", "-o", table)
    own = gravical.motion(line, cal)
    alike(own, theirs)
    own.save(tmp_path / "own.csv")
    assert (tmp_path / "own.csv").read_bytes() == table.read_bytes()
    names, written = table_of(table)
    frame = own.to_pandas()
    assert list(frame) == names
    assert np.allclose(frame.to_numpy(dtype=float), written, rtol=0, atol=1e-6, equal_nan=True)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_denoise(path: str, program: Program, tmp_path: Path) -> None:
    filters, a, b = ["hampel:7,3", "butter:4,5Hz"], tmp_path / "a.csv", tmp_path / "b.csv"
    words = ["-f", filters[0], "-f", filters[1], "--json", "-q", "-o", a]
    theirs = program("denoise", path, *words)
    both(lambda: gravical.denoise(path, filters, output=b), theirs)
    if "code" not in theirs:
        assert a.read_bytes() == b.read_bytes()
        # In memory the numbers are the same.
        alike(gravical.denoise(path, filters).filters, theirs["filters"])


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
    frame = gravical.apply(cal, path, output_unit=unit).to_pandas().drop(columns="t_s")
    columns = written[:, [names.index(name) for name in frame]]
    assert np.abs(frame.to_numpy() - columns).max() <= 0.5e-6 + 1e-12


def test_compare(program: Program, calibration: gravical.Calibration, tmp_path: Path) -> None:
    a, b = tmp_path / "a.json", tmp_path / "b.json"
    calibration.save(a)
    gravical.calibrate("examples/demo/poses").save(b)
    alike(gravical.compare(a, b), program("compare", a, b, "--json"))


@pytest.mark.parametrize(
    ("scenario", "options"),
    [
        ("six-position", {"continuous": True, "rate": 50.0, "raw": True}),
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
            assert to == "kalibr", error
            assert error.hint and "(noise=" in error.hint
            return
    theirs = program("export", cal, "--to", to, parse=False)

    def without_date(text: str) -> list[str]:
        return [line for line in text.splitlines() if "created" not in line]

    assert without_date(own) == without_date(theirs)


def test_streaming_has_the_numbers_of_causal(
    program: Program, calibration: gravical.Calibration, tmp_path: Path
) -> None:
    cal = tmp_path / "cal.json"
    calibration.save(cal)
    made = gravical.simulate("line", seed=3, output=tmp_path / "line")
    table = tmp_path / "track.csv"
    program("motion", made.paths[0], "-c", cal, "--causal", "-q", "-o", table, parse=False)
    header, written = table_of(table)
    recording = gravical.read(made.paths[0])
    t, gyro = recording.t, recording.gyro
    assert t is not None and gyro is not None and recording.temperature is not None
    live = gravical.Motion(recording, cal)
    states = live.extend(t, recording.accel, gyro, recording.temperature)

    def column(*names: str) -> Any:
        return written[:, [header.index(name) for name in names]]

    # The noise is learned from the first 3 s, of which the program tells more afterwards.
    known = np.isfinite(states.position[:, 0])
    assert np.array_equal(known, t - t[0] > 2.995)
    assert np.array_equal(known, np.isfinite(states.sigma_position[:, 0]))
    # A move is gone through again once the rest after it is known.
    position = column("px_m", "py_m", "pz_m")
    band = column("sigma_px_m", "sigma_py_m", "sigma_pz_m")
    rests = states.still & (column("still")[:, 0] == 1) & known
    assert rests[-1] and rests.sum() > 500
    apart = np.abs(states.position - position)
    assert apart[rests].max() <= 0.5001e-6
    assert np.abs(states.sigma_position - band)[rests].max() <= 0.5001e-6
    moves = known & ~states.still
    assert (apart <= 3 * states.sigma_position)[moves].all()
    # Sample by sample it is the same, to the last bit.
    live = gravical.Motion(recording, cal)
    samples = zip(t, recording.accel, gyro, recording.temperature)
    ones = [live.update(*sample) for sample in samples]
    assert np.array_equal([one.position for one in ones], states.position, equal_nan=True)
