"""Whatever is given: an exception that says what and what to do, never a panic or a crash.

GRAVICAL_SEED=7 pytest tests/test_bad_input.py draws others, GRAVICAL_DRAWN=100000 more of them.
"""

from __future__ import annotations

import os
import random
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pandas as pd
import polars as pl

SEED = int(os.environ.get("GRAVICAL_SEED", "1"))
DRAWN = int(os.environ.get("GRAVICAL_DRAWN", "1500"))

Call = Callable[[], Any]


def value(r: random.Random) -> Any:
    return r.choice(
        [0, -1, 1, 3, 9.81, 1e300, -1e300, 1e-300, float("nan"), float("inf"), 2**70, -(2**70),
         True, None, "9.81", "", "x", b"9", [], [1.0], (1, 2, 3), {}, np.float32(1), np.int8(-3),
         np.array(5.0), np.array([1.0, 2.0]), object(), 1j, "0-1", "a,b,c", "--rate", "\0", "é" * 40]
    )  # fmt: skip


def array(r: random.Random) -> Any:
    rows = r.choice([0, 1, 2, 3, 5, 100, 400])
    shape = r.choice([(rows, 3), (rows, 3), (rows, 3), (3, rows), (rows,), (rows, 2), (rows, 3, 1), ()])
    values = np.random.default_rng(r.randrange(2**32)).normal(0, r.choice([1e-3, 1.0, 1e6]), shape)
    if shape[1:] == (3,) and r.random() < 0.7:
        values[:, 2] += r.choice([9.81, 1.0, 1000.0, 16384.0])
    if r.random() < 0.3 and values.size:
        values.flat[r.randrange(values.size)] = r.choice([np.nan, np.inf, -np.inf, 1e30])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        kinds: list[Any] = [float, float, float, np.float32, np.int16, bool, object, complex, str, ">f8"]
        values = values.astype(r.choice(kinds))
    if r.random() < 0.2 and values.ndim:
        values = values[:: r.choice([-1, 2, 3])]
    return np.asfortranarray(values) if r.random() < 0.1 else values


NAMES = ["t", "time", "ax", "ay", "az", "acc_x", "acc_y", "acc_z", "gx", "gy", "gz", "label", "x", "y",
         "z", "", "temp", "a,b", 0, 1, 2, "Timestamp (ms)", "sensor", "☃"]  # fmt: skip


def table(r: random.Random) -> Any:
    rows = r.choice([0, 1, 2, 50, 300])
    g = np.random.default_rng(r.randrange(2**32))
    kinds: list[Call] = [
        *[lambda: g.normal(9.81, 0.02, rows)] * 4,
        lambda: np.arange(rows) * 10,
        lambda: [r.choice(["+x", "-x", None, "", "nonsense"]) for _ in range(rows)],
        lambda: np.datetime64("2026-01-01") + np.arange(rows) * np.timedelta64(10, "ms"),
        lambda: np.full(rows, np.nan),
    ]
    names = r.sample(NAMES, r.randrange(0, 9)) + r.choice([[], ["ax", "ay", "az"]])
    columns = {name: r.choice(kinds)() for name in names}
    if r.random() < 0.1 and columns:
        columns[r.choice(list(columns))] = array(r)
    try:
        return r.choice([dict, pd.DataFrame, pl.DataFrame])(columns)
    except Exception:
        return columns


def text(r: random.Random) -> bytes:
    lines = [
        b"t,ax,ay,az", b"t_ms;ax;ay;az;gx;gy;gz", b"# a comment", b"", b"1,2,3", b"0.1,0.2,0.3,9.8",
        b"nan,nan,nan,nan", b"\xff\xfe\x00", b"1e999,1,1,1", b",,,", b'"a","b","c","d"', b"{}", b"\0" * 50,
        b"0,0,0,0", b"32768,32768,32768,49152",
    ]  # fmt: skip
    out = r.choices(lines, k=r.randrange(30)) + [r.choice(lines)] * r.choice([0, 0, r.randrange(300)])
    return r.choice([b"\n", b"\r\n", b"\r"]).join(out)


def source(r: random.Random, folder: Path, good: Any) -> Any:
    path = folder / f"{r.randrange(10**9)}.csv"
    path.write_bytes(text(r))
    kinds: list[Call] = [
        *[lambda: good] * 2,
        *[lambda: table(r)] * 2,
        lambda: text(r),
        lambda: path,
        lambda: r.choice([folder / "missing.csv", folder, "", "\0", "/dev/null", Path("no/such")]),
        lambda: [source(r, folder, good) for _ in range(r.randrange(0, 4))],
        lambda: {r.choice(["+x", "-x", "a", 3]): array(r) for _ in range(r.randrange(0, 4))},
        lambda: r.choice([None, 3, 2.5, object(), array(r), True, lambda: None]),
    ]
    return r.choice(kinds)()


READING = ["accel_unit", "accel_range", "gyro_unit", "gyro_range", "columns", "sensor", "rate",
           "time_unit", "zero_offset"]  # fmt: skip
GRAVITY = ["gravity", "latitude", "altitude", "axes"]
OWN: dict[str, list[str]] = {
    "read": ["gyro"],
    "inspect": ["axes"],
    "calibrate": [*GRAVITY, "method", "sections", "pose_tilt",
                  "prior", "free_pose", "face_pose", "thermal", "sensor_id", "recorded"],
    "apply": ["axes", "output_unit", "keep_raw", "output"],
    "denoise": [],
    "noise": [],
    "motion": [*GRAVITY, "procedure", "rests", "no_stances"],
    "check": GRAVITY,
}  # fmt: skip
SIMULATED = ["seed", "rate", "range", "decimals", "noise", "tilt", "jitter", "drop", "raw"]


def drawn(
    r: random.Random, folder: Path, line: gravical.Recording, calibration: gravical.Calibration
) -> Call:
    """A call, drawn at random."""
    verb = r.choice([*OWN, "simulate", "arrays", "use", "compare", "load"])
    names = OWN.get(verb, []) + READING
    given: dict[str, Any] = {k: value(r) for k in r.sample(names, r.choice([0, 0, 1, 1, 2, 3]))}
    what, raw, other, any_value = source(r, folder, line), array(r), array(r), value(r)
    target: Any = r.choice([folder / "x.docx", "", folder, "\0.html", folder / "no/such/x.json"])
    if "output" in given:
        given["output"] = r.choice([target, folder / f"{r.randrange(10**9)}.out", what])
    if verb == "simulate":
        some = {k: value(r) for k in r.sample(SIMULATED, 2)}
        scenarios: list[Any] = ["line", "poses", "x", 3]
        return lambda: gravical.simulate(r.choice(scenarios), **some)
    if verb == "arrays":
        fields = r.sample(["t", "gyro", "temperature", "labels", "accel_unit", "name"], r.randrange(0, 4))
        kept = {n: value(r) if r.random() < 0.3 else array(r) for n in fields}
        return lambda: gravical.Recording.from_arrays(accel=raw, **kept)
    if verb == "use":
        option = r.choice(["name", "counts_per_deg_s", "counts_per_g"])
        uses: list[Call] = [
            lambda: calibration.apply(raw),
            lambda: calibration.apply_gyro(raw, other),
            lambda: calibration.export(r.choice(["c", str(any_value)]), **{option: any_value}),
            lambda: calibration.report(target),
            lambda: calibration.save(target),
        ]
        return r.choice(uses)
    if verb == "load":
        path, good = folder / "broken.json", calibration.to_json().encode()
        at = r.randrange(len(good))
        path.write_bytes(good[:at] + bytes([r.randrange(256)]) + good[at + r.randrange(3) :])
        return lambda: gravical.Calibration.load(path)
    if verb == "compare":
        return lambda: gravical.compare(calibration, source(r, folder, calibration))
    if verb in ("apply", "check"):
        with_what = calibration if r.random() < 0.8 else source(r, folder, calibration)
        return lambda: getattr(gravical, verb)(with_what, what, **given)
    if verb == "denoise":
        filters = ["butter:4,5Hz", "savgol:5,2", "savgol:1e9,2", "x", ["hampel:7,3", 3], any_value]
        return lambda: gravical.denoise(what, r.choice(filters), **given)
    return lambda: getattr(gravical, verb)(what, **given)


def test_a_thousand_bad_calls(
    tmp_path: Path, line: gravical.Recording, calibration: gravical.Calibration
) -> None:
    counts = {"result": 0, "error": 0, "type": 0}
    for number in range(DRAWN):
        call = drawn(random.Random(f"{SEED}:{number}"), tmp_path, line, calibration)
        place = f"GRAVICAL_SEED={SEED}, call {number}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                call()
                counts["result"] += 1
            except gravical.Error as error:
                counts["error"] += 1
                assert error.code != "internal" and 0 < len(error.message) < 4000, place
            except TypeError as error:
                # Of Python itself: a keyword that does not exist, a name that is no text.
                counts["type"] += 1
                assert str(error), place
            except BaseException as error:
                raise AssertionError(f"{place}: {type(error).__name__}: {error}") from error
    assert counts["error"] > DRAWN // 4 and counts["result"] > DRAWN // 20, counts
    assert counts["type"] < DRAWN // 10, counts
