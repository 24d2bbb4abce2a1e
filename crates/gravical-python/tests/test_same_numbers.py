"""The numbers of the program, to the last bit, for every verb on every example."""

from __future__ import annotations

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
    ("examples/demo/poses", {"method": "magnitude9", "prior": "off", "axes": "y,-x,z"}),
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
    return [
        word
        for name, value in options.items()
        for word in (f"--{name.replace('_', '-')}={value}",)
    ]


def alike(own: dict[str, Any], theirs: dict[str, Any]) -> None:
    """Equal, every number to the last bit; a failure names the first place that is not."""

    def differ(a: Any, b: Any, place: str) -> None:
        if isinstance(a, dict) and isinstance(b, dict):
            assert a.keys() - set(VARIES) == b.keys() - set(VARIES), place
            for key in a.keys() - set(VARIES):
                differ(a[key], b[key], f"{place}.{key}")
        elif isinstance(a, list) and isinstance(b, list):
            assert len(a) == len(b), place
            for i, (one, other) in enumerate(zip(a, b)):
                differ(one, other, f"{place}[{i}]")
        else:
            assert a == b and type(a) is type(b), f"{place}: {a!r} {b!r}"

    differ(own, theirs, "")


def outcome(call: Any) -> tuple[str, Any]:
    try:
        return "result", call().to_dict()
    except gravical.Error as error:
        return "error", error.code


def both(call: Any, theirs: dict[str, Any]) -> None:
    """The same result, or the same error."""
    kind, own = outcome(call)
    if kind == "error":
        assert own == theirs.get("code"), (own, theirs)
    else:
        assert "code" not in theirs, theirs
        alike(own, theirs)


def resolved(name: str, request: pytest.FixtureRequest) -> str:
    if name.startswith("examples"):
        return name
    return str(request.getfixturevalue("data") / name)


@pytest.fixture(autouse=True)
def in_root(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Names of files are those that the program is given."""
    monkeypatch.chdir(root)


@pytest.mark.parametrize(("name", "options"), SESSIONS + DATA_SESSIONS)
def test_calibrate_and_check(
    name: str,
    options: dict[str, Any],
    program: Program,
    request: pytest.FixtureRequest,
    tmp_path: Path,
) -> None:
    path = resolved(name, request)
    theirs = program("calibrate", path, "--json", *flags(options))
    both(lambda: gravical.calibrate(path, **options), theirs)
    if "code" in theirs:
        return
    # Saved, it is the file of the program; a check of it is the program's.
    file = tmp_path / "cal.json"
    gravical.calibrate(path, **options).save(file)
    program("calibrate", path, "-o", tmp_path / "own.json", *flags(options), parse=False)
    alike(
        gravical.Calibration.load(file).to_dict(),
        gravical.Calibration.load(tmp_path / "own.json").to_dict(),
    )
    reading = {k: v for k, v in options.items() if k in ("rate", "axes", "gravity")}
    theirs = program("check", file, path, "--json", *flags(reading))
    both(lambda: gravical.check(file, path, **reading), theirs)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_inspect(
    name: str, program: Program, request: pytest.FixtureRequest
) -> None:
    path = resolved(name, request)
    theirs = program("inspect", path, "--json")
    if theirs["recordings"]:
        alike(gravical.inspect(path).to_dict(), theirs["recordings"][0])
    else:
        with pytest.raises(gravical.Error) as error:
            gravical.inspect(path)
        assert error.value.code == theirs["errors"][0]["code"]


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_motion(name: str, program: Program, request: pytest.FixtureRequest) -> None:
    path = resolved(name, request)
    options: dict[str, Any] = {} if "phone" not in name else {"tilt_change": 1.5}
    theirs = program("motion", path, "--json", "--quiet", *flags(options))
    both(lambda: gravical.motion(path, **options), theirs)


def test_motion_with_a_calibration_and_its_table(
    program: Program, calibration: gravical.Calibration, tmp_path: Path
) -> None:
    cal, line = tmp_path / "cal.json", tmp_path / "line"
    calibration.save(cal)
    made = gravical.simulate("line", seed=3, output=line)
    path = made.paths[0]
    table = tmp_path / "track.csv"
    theirs = program("motion", path, "-c", cal, "--json", "--quiet", "-o", table)
    own = gravical.motion(path, cal)
    alike(own.to_dict(), theirs)
    own.save(tmp_path / "own.csv")
    assert (tmp_path / "own.csv").read_bytes() == table.read_bytes()
    columns = own.to_pandas()
    lines = [line.split(",") for line in table.read_text().splitlines()]
    assert list(columns) == lines[0]
    for at, name in enumerate(lines[0]):
        cells = [line[at] for line in lines[1:]]
        decimals = max(len(cell.partition(".")[2]) for cell in cells)
        written = np.array([float(cell) if cell else np.nan for cell in cells])
        error = np.abs(columns[name].to_numpy(dtype=float) - written)
        assert np.nanmax(error) <= 0.5001 * 10.0**-decimals, name


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS[:5])
def test_noise(
    name: str, program: Program, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    path = resolved(name, request)
    words = ["--json", "--spacing", "dense", "--term", "q", "-q", "-o", tmp_path / "noise.json"]
    theirs = program("noise", path, *words)
    both(lambda: gravical.noise(path, spacing="dense", term="q"), theirs)


@pytest.mark.parametrize("name", RECORDINGS + DATA_RECORDINGS)
def test_denoise(
    name: str, program: Program, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    path = resolved(name, request)
    filters = ["hampel:7,3", "butter:4,5Hz"]
    theirs = program(
        "denoise", path, "-f", filters[0], "-f", filters[1], "--json", "-q",
        "-o", tmp_path / "a.csv",
    )
    both(lambda: gravical.denoise(path, filters, output=tmp_path / "b.csv"), theirs)
    if "code" not in theirs:
        assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
        # In memory the numbers are the same.
        own = gravical.denoise(path, filters).to_dict()
        assert own["filters"] == theirs["filters"]


@pytest.mark.parametrize("name", ["examples/demo/line/line.csv", "examples/demo/poses/poses.csv"])
@pytest.mark.parametrize("unit", ["m/s^2", "g"])
def test_apply(
    name: str, unit: Any, program: Program, tmp_path: Path
) -> None:
    cal = tmp_path / "cal.json"
    gravical.calibrate("examples/demo/poses", gravity=9.80665).save(cal)
    theirs = program(
        "apply", cal, name, "-o", tmp_path / "a.csv", "--json", "-q", "--output-unit", unit
    )
    own = gravical.apply(cal, name, output=tmp_path / "b.csv", output_unit=unit)
    alike(own.to_dict(), theirs)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    # In memory: the same before it is rounded to six decimals.
    applied = gravical.apply(cal, name, output_unit=unit)
    rows = (tmp_path / "a.csv").read_text().splitlines()
    header = rows[0].split(",")
    for column, values in applied.columns.items():
        at = header.index(column)
        written = np.array([float(row.split(",")[at]) for row in rows[1:]])
        assert np.abs(values - written).max() <= 0.5e-6 + 1e-12, column


def test_compare(program: Program, calibration: gravical.Calibration, tmp_path: Path) -> None:
    a, b = tmp_path / "a.json", tmp_path / "b.json"
    calibration.save(a)
    gravical.calibrate("examples/demo/poses").save(b)
    alike(gravical.compare(a, b).to_dict(), program("compare", a, b, "--json"))


@pytest.mark.parametrize(
    ("scenario", "options"),
    [
        ("six-position", {"seed": 7, "hold": 3.0, "raw": True}),
        ("six-position", {"continuous": True, "turn_time": 5.0, "rate": 50.0}),
        ("poses", {"free": 3, "tilt": 0.5, "noise": 2.0, "decimals": 6}),
        ("static", {"duration": 20.0, "soak": (50, -10), "gyro_drift": 0.01, "rate": 20.0}),
        ("line", {"distance": -0.3, "jitter": 1.0, "drop": 0.05, "wrong_header": True}),
    ],
)
def test_simulate(
    scenario: Any, options: dict[str, Any], program: Program, tmp_path: Path
) -> None:
    words: list[str] = []
    for name, value in options.items():
        flag = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(flag)
        else:
            text = ",".join(map(str, value)) if isinstance(value, tuple) else value
            words.append(f"{flag}={text}")
    theirs = program("simulate", scenario, "-o", tmp_path / "a", "--json", "-q", *words)
    made = gravical.simulate(scenario, output=tmp_path / "b", **options)
    alike(made.truth, theirs)
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
    ids: dict[str, Any] = {"device_id": 2621448} if to in ("px4", "ardupilot") else {}
    cal_flags = flags(ids)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gravical.ExportWarning)
        try:
            own = calibration.export(to, **ids)
        except gravical.Error as error:
            assert to == "kalibr", error
            assert error.hint and "noise=" in error.hint
            return
    theirs = program("export", cal, "--to", to, *cal_flags, parse=False)

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
    written = np.genfromtxt(table, delimiter=",", skip_header=1)
    header = table.read_text().splitlines()[0].split(",")
    recording = gravical.read(made.paths[0])
    t, gyro = recording.t, recording.gyro
    assert t is not None and gyro is not None
    live = gravical.Motion(recording, cal)
    states = live.extend(t, recording.accel, gyro, recording.temperature)
    at = [header.index(name) for name in ("px_m", "py_m", "pz_m")]
    known = np.isfinite(written[:, at[0]])
    assert known.sum() > 1000
    assert np.array_equal(known, np.isfinite(states.position[:, 0]))
    assert np.abs(states.position[known] - written[known][:, at]).max() <= 0.5001e-6
    # Sample by sample it is the same, to the last bit.
    live = gravical.Motion(recording, cal)
    temperature = recording.temperature
    assert temperature is not None
    for i in range(len(t)):
        one = live.update(t[i], recording.accel[i], gyro[i], temperature[i])
        assert np.array_equal(one.position, states.position[i], equal_nan=True)
