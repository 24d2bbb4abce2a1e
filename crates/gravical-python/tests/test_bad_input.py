"""Whatever is given: an exception that says what and what to do, never a panic or a crash.

GRAVICAL_SEED=7 pytest tests/test_bad_input.py draws others, GRAVICAL_DRAWN=100000 more of them.
"""

from __future__ import annotations

import os
import random
import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gravical
import numpy as np
import pandas as pd
import polars as pl
from gravical._verbs import _SCENARIOS, _SHARED

SEED = int(os.environ.get("GRAVICAL_SEED", "1"))
DRAWN = int(os.environ.get("GRAVICAL_DRAWN", "1500"))


def numbers(r: random.Random) -> Any:
    return r.choice(
        [0, -1, 1, 3, 9.81, 1e300, -1e300, 1e-300, float("nan"), float("inf"), 2**70, -(2**70),
         True, None, "9.81", "", "x", b"9", [], [1.0], (1, 2, 3), {}, np.float32(1), np.int8(-3),
         np.array(5.0), np.array([1.0, 2.0]), object(), 1j, "0-1", "a,b,c", "--rate", "\0", "é" * 40]
    )  # fmt: skip


def array(r: random.Random) -> Any:
    rows = r.choice([0, 1, 2, 3, 5, 100, 400])
    shape = r.choice([(rows, 3), (rows, 3), (rows, 3), (3, rows), (rows,), (rows, 2), (rows, 3, 1), ()])
    g = np.random.default_rng(r.randrange(2**32))
    values = g.normal(0, r.choice([1e-3, 1.0, 1e6]), shape)
    if len(shape) == 2 and shape[1] == 3 and r.random() < 0.7:
        values[:, 2] += r.choice([9.81, 1.0, 1000.0, 16384.0])
    dtype = r.choice([float, float, float, np.float32, np.int16, np.int64, bool, object, complex, str])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            values = values.astype(dtype)
        except (TypeError, ValueError):
            pass
    if r.random() < 0.3 and values.dtype.kind == "f" and values.size:
        values.flat[r.randrange(values.size)] = r.choice([np.nan, np.inf, -np.inf, 1e30])
    if r.random() < 0.2 and values.ndim:
        values = values[:: r.choice([-1, 2, 3])]
    if r.random() < 0.1:
        values = np.asfortranarray(values)
    if r.random() < 0.1 and values.dtype.kind == "f":
        values = values.astype(">f8")
    return values


def table(r: random.Random) -> Any:
    rows = r.choice([0, 1, 2, 50, 300])
    names = r.sample(
        ["t", "time", "ax", "ay", "az", "acc_x", "acc_y", "acc_z", "gx", "gy", "gz", "label", "x", "y",
         "z", "", "temp", "a,b", 0, 1, 2, "ax", "Timestamp (ms)", "sensor", "☃"],
        r.randrange(0, 9),
    )  # fmt: skip
    if r.random() < 0.5:
        names += ["ax", "ay", "az"]
    g = np.random.default_rng(r.randrange(2**32))

    def column() -> Any:
        kind = r.randrange(8)
        if kind < 4:
            return g.normal(9.81, 0.02, rows)
        if kind == 4:
            return np.arange(rows) * 10
        if kind == 5:
            return [r.choice(["+x", "-x", None, "", "nonsense"]) for _ in range(rows)]
        if kind == 6:
            return np.datetime64("2026-01-01") + np.arange(rows) * np.timedelta64(10, "ms")
        return np.full(rows, np.nan)

    columns = {name: column() for name in names}
    if r.random() < 0.1 and columns:
        columns[r.choice(list(columns))] = array(r)
    kind = r.randrange(3)
    try:
        if kind == 1:
            return pd.DataFrame(columns)
        if kind == 2:
            return pl.DataFrame({str(k): v for k, v in columns.items()})
    except Exception:
        pass
    return columns


def text(r: random.Random) -> bytes:
    lines = [
        b"t,ax,ay,az", b"t_ms;ax;ay;az;gx;gy;gz", b"# a comment", b"", b"1,2,3", b"0.1,0.2,0.3,9.8",
        b"nan,nan,nan,nan", b"\xff\xfe\x00", b"1e999,1,1,1", b",,,", b'"a","b","c","d"', b"{}", b"\0" * 50,
        b"0,0,0,0", b"32768,32768,32768,49152",
    ]  # fmt: skip
    out = [r.choice(lines) for _ in range(r.randrange(0, 30))]
    if r.random() < 0.4:
        line = r.choice(lines)
        out += [line] * r.randrange(0, 300)
    return r.choice([b"\n", b"\r\n", b"\r"]).join(out)


def source(r: random.Random, folder: Path, good: Any) -> Any:
    kind = r.randrange(10)
    if kind < 2:
        return good
    if kind < 4:
        return table(r)
    if kind == 4:
        return text(r)
    if kind == 5:
        path = folder / f"{r.randrange(10**9)}.csv"
        path.write_bytes(text(r))
        return path
    if kind == 6:
        return r.choice([folder / "missing.csv", folder, "", "\0", "/dev/null", Path("no/such")])
    if kind == 7:
        return [source(r, folder, good) for _ in range(r.randrange(0, 4))]
    if kind == 8:
        return {r.choice(["+x", "-x", "a", 3]): array(r) for _ in range(r.randrange(0, 4))}
    return r.choice([None, 3, 2.5, object(), array(r), True, lambda: None])


READING = ["accel_unit", "accel_range", "gyro_unit", "gyro_range", "columns", "sensor", "rate",
           "time_unit", "zero_offset"]  # fmt: skip
GRAVITY = ["gravity", "latitude", "altitude", "axes"]
OWN: dict[str, list[str]] = {
    "read": ["gyro"],
    "inspect": ["axes"],
    "calibrate": [*GRAVITY, "method", "sections", "rows", "faces_from", "turn_angle", "pose_tilt",
                  "prior", "free_pose", "face_pose", "thermal", "noise", "sensor_id", "recorded"],
    "apply": ["axes", "output_unit", "keep_raw", "output"],
    "denoise": ["edge", "channels"],
    "noise": ["spacing", "term", "part", "full"],
    "motion": [*GRAVITY, *gravical.MotionOptions.__annotations__, "noise", "truth"],
    "check": GRAVITY,
    "simulate": ["seed", "free", "rate", "range", "duration", "hold", "soak", "decimals", "noise"],
}  # fmt: skip


def options(r: random.Random, verb: str) -> dict[str, Any]:
    names = OWN[verb] + (READING if verb != "simulate" else [])
    return {name: numbers(r) for name in r.sample(names, r.choice([0, 0, 1, 1, 2, 3]))}


def calls(
    r: random.Random, folder: Path, line: gravical.Recording, calibration: gravical.Calibration
) -> tuple[str, Callable[[], Any]]:
    """A call, drawn at random."""
    verb = r.choice([*OWN, "arrays", "use", "stream", "compare", "load"])
    if verb == "arrays":
        names: list[str] = r.sample(["t", "gyro", "temperature", "labels", "unit", "name"], r.randrange(0, 4))
        kept: dict[str, Any] = {n: numbers(r) if r.random() < 0.3 else array(r) for n in names}
        accel = array(r) if r.random() < 0.9 else numbers(r)
        return verb, lambda: gravical.Recording.from_arrays(accel=accel, **kept)
    if verb == "use":
        raw, other = array(r), array(r)
        target: Any = r.choice([folder / "x.docx", "", folder, "\0.html", folder / "no/such/x.json"])
        uses: list[Callable[[], Any]] = [
                lambda: calibration.apply(raw),
                lambda: calibration.apply_gyro(raw, other),
                lambda: calibration.export(str(numbers(r)), name=numbers(r)),
                lambda: calibration.export("c", **{r.choice(["name", "rotation", "counts_per_g"]): numbers(r)}),
                lambda: calibration.report(target),
                lambda: calibration.save(target),
                lambda: gravical.filtered(raw, numbers(r), rate=numbers(r)),
                lambda: gravical.filtered(raw, "butter:4,5Hz", rate=100),
                lambda: gravical.allan(raw, rate=numbers(r)),
                lambda: gravical.allan(raw, rate=100),
        ]
        return verb, r.choice(uses)
    if verb == "stream":
        live = gravical.Motion(line, calibration)
        of_stream = options(r, "motion")
        for name in ("noise", "truth"):
            of_stream.pop(name, None)
        sample = [numbers(r) for _ in range(3)]
        chunk = [array(r) for _ in range(3)]
        return verb, r.choice(
            [
                lambda: live.update(*sample),
                lambda: live.extend(*chunk),
                lambda: gravical.Motion(source(r, folder, line), calibration, **of_stream),
            ]
        )
    if verb == "compare":
        other = source(r, folder, calibration)
        return verb, lambda: gravical.compare(calibration, other)
    if verb == "load":
        path = folder / "broken.json"
        good = calibration.to_json().encode()
        at = r.randrange(len(good))
        path.write_bytes(good[:at] + bytes([r.randrange(256)]) + good[at + r.randrange(3) :])
        return verb, lambda: gravical.Calibration.load(path)
    given = options(r, verb)
    if verb == "simulate":
        scenario: Any = r.choice(["six-position", "poses", "static", "line", "x", 3])
        own = _SCENARIOS.get(scenario, frozenset()) | _SHARED
        given = {k: v for k, v in given.items() if k in own}
        # Not hours of it.
        some: dict[str, Any] = {
            k: v for k, v in given.items() if not isinstance(v, float) or v < 1e3
        }
        return verb, lambda: gravical.simulate(scenario, **some)
    what = source(r, folder, line)
    if "output" in given:
        given["output"] = r.choice([folder / f"{r.randrange(10**9)}.out", folder, "\0", what])
    if verb in ("apply", "check"):
        function = getattr(gravical, verb)
        with_what = calibration if r.random() < 0.8 else source(r, folder, calibration)
        return verb, lambda: function(with_what, what, **given)
    if verb == "denoise":
        filters: Any = r.choice(["butter:4,5Hz", "mean:5", "savgol:1e9,2", "x", ["hampel:7,3", 3], numbers(r)])
        return verb, lambda: gravical.denoise(what, filters, **given)
    return verb, lambda: getattr(gravical, verb)(what, **given)


def test_a_thousand_bad_calls(
    tmp_path: Path, line: gravical.Recording, calibration: gravical.Calibration
) -> None:
    print(f"GRAVICAL_SEED={SEED}")
    counts = {"result": 0, "error": 0, "type": 0}
    for number in range(DRAWN):
        r = random.Random(f"{SEED}:{number}")
        verb, call = calls(r, tmp_path, line, calibration)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                call()
                counts["result"] += 1
            except gravical.Error as error:
                counts["error"] += 1
                place = f"GRAVICAL_SEED={SEED}, call {number} ({verb})"
                assert error.code != "internal" and error.message, place
                said = f"{error.message} {error.hint or ''}"
                assert not re.search(r"(?<![\w'-])--(rate|accel|gyro|gravity|columns)", said), (place, said)
                assert len(error.message) < 4000, place
            except TypeError as error:
                # Of Python itself: a keyword that does not exist, a name that is no text.
                counts["type"] += 1
                assert str(error), number
            except BaseException as error:
                raise AssertionError(
                    f"GRAVICAL_SEED={SEED}, call {number} ({verb}): {type(error).__name__}: {error}"
                ) from error
    print(counts)
    assert counts["error"] > DRAWN // 4 and counts["result"] > DRAWN // 20, counts
    assert counts["type"] < DRAWN // 10, counts
