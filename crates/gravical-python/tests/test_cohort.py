"""Many recordings over engines: the results of the plain run, whatever happens to the engine."""

from __future__ import annotations

import json
import os
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gravical
import pytest
from conftest import Program
from gravical import cohort

distributed = pytest.importorskip("distributed")

HERE = Path(__file__).parent
GRAVITY = 9.80665


class Cluster:
    """A scheduler and two workers, each a process of its own."""

    def __init__(self, folder: Path) -> None:
        self.log = open(folder / "cluster.log", "a")
        self.file = folder / "scheduler.json"
        self.file.unlink(missing_ok=True)
        shared = ["--scheduler-file", str(self.file), "--no-dashboard"]
        address = ["--host", "127.0.0.1"]
        self.scheduler = self.start("scheduler", *shared, *address, "--port", "0")
        worker = ["worker", *shared, *address, "--nthreads", "1", "--death-timeout", "60"]
        worker += ["--preload", str(HERE / "deadly.py")]
        self.workers = [self.start(*worker, "--local-directory", str(folder)) for _ in range(2)]

    def start(self, *words: str) -> subprocess.Popen[bytes]:
        paths = os.pathsep.join(sys.path)
        set_up = {**os.environ, "PYTHONPATH": paths, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
        line = [sys.executable, "-m", "dask", *words]
        return subprocess.Popen(line, env=set_up, stdout=self.log, stderr=self.log)

    def client(self) -> Any:
        client = distributed.Client(scheduler_file=str(self.file), timeout=30)
        client.wait_for_workers(2, timeout=30)
        return client

    def end(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.terminate()
        for process in [*self.workers, self.scheduler]:
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
        self.log.close()


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    cluster = Cluster(tmp_path_factory.mktemp("cluster"))
    client = cluster.client()
    yield client
    client.shutdown()
    cluster.end()


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Six sessions, and a file that is none."""
    folder = tmp_path_factory.mktemp("sessions")
    paths = []
    for seed in range(1, 7):
        made = gravical.simulate("poses", free=3, seed=seed, output=folder / str(seed))
        paths.append(Path(shutil.move(made.paths[0], folder / f"unit-{seed}.csv")))
    paths.append(folder / "none.csv")
    paths[-1].write_text("t,ax,ay,az\n1,2\n")
    return paths


def copies(of: Path, folder: Path, *names: str) -> list[Path]:
    return [Path(shutil.copy(of, folder / f"{name}.csv")) for name in names]


def by_name(rows: Any) -> dict[str, Any]:
    listed = list(rows)
    named = {row["name"]: row for row in listed}
    assert len(named) == len(listed), "a row is there twice"
    return named


def collected(program: Program, out: Path) -> Any:
    return program("collect", out, "--json")["counts"]


def same(a: Path, b: Path) -> bool:
    """Two calibration files, but for the command and the time."""
    one, other = (json.loads(path.read_text()) for path in (a, b))
    for name in ("command", "created"):
        one.pop(name), other.pop(name)
    return bool(one == other) and json.dumps(one) == json.dumps(other)


def test_the_results_are_those_of_the_plain_run(
    client: Any, sessions: list[Path], program: Program, tmp_path: Path
) -> None:
    rows = by_name(
        cohort.submit(client, sessions, "calibrate", tmp_path / "dask", gravity=GRAVITY, window=2)
    )
    listed = tmp_path / "list"
    listed.write_text("\n".join(map(str, sessions)))
    summary = tmp_path / "plain.json"
    each = ["calibrate", "--each", f"@{listed}", "--gravity", GRAVITY, "-o"]
    program(*each, tmp_path / "plain", "--summary", summary, parse=False)
    plain = by_name(json.loads(summary.read_text())["rows"])
    assert rows.keys() == plain.keys()
    for name, row in rows.items():
        if row["status"] == "error":
            assert name == "none" and row["error_code"] == plain[name]["error_code"] == "no-rows"
            continue
        assert same(Path(row["result"]), Path(plain[name]["result"]))
        assert {**row, "result": None} == {**plain[name], "result": None}
    counts = collected(program, tmp_path / "dask")
    assert (counts["items"], counts["done"], counts["error"]) == (7, 6, 1)
    # The program continues what an engine began, and finds nothing left to be done.
    text = program(*each, tmp_path / "dask", "--resume", "--json", parse=False)
    again = by_name(map(json.loads, text.splitlines()))
    assert {n: r["sha256"] for n, r in again.items()} == {n: r["sha256"] for n, r in rows.items()}
    first = json.loads((tmp_path / "dask" / "unit-1.json").read_text())
    assert first["command"] is None, "it was made again"


def test_check_noise_and_apply(
    client: Any, sessions: list[Path], program: Program, tmp_path: Path
) -> None:
    calibration = gravical.calibrate(sessions[0], gravity=GRAVITY)
    file = tmp_path / "c.json"
    calibration.save(file)
    rest = gravical.simulate("static", duration=60, output=tmp_path / "rest").paths[0]
    runs: list[tuple[str, list[Path], dict[str, Any]]] = [
        ("check", sessions[:2], {"calibration": file}),
        ("apply", sessions[:2], {"calibration": file}),
        ("noise", [Path(rest)], {}),
    ]
    for task, paths, options in runs:
        out, plain = tmp_path / task, tmp_path / f"plain-{task}"
        rows = by_name(cohort.submit(client, paths, task, out, **options))
        summary = tmp_path / f"{task}.json"
        words = [*options.values(), "--each", *paths, "--summary", summary]
        words += [] if task == "check" else ["-o", plain]
        program(task, *words, parse=False)
        expected = by_name(json.loads(summary.read_text())["rows"])
        for name, row in rows.items():
            assert {**row, "result": None} == {**expected[name], "result": None}
            if task == "apply":
                assert Path(row["result"]).read_bytes() == (plain / f"{name}.csv").read_bytes()


def test_what_is_done_is_skipped_and_what_changed_is_not(
    client: Any, sessions: list[Path], tmp_path: Path
) -> None:
    paths = copies(sessions[0], tmp_path, "a", "b", "c")
    out = tmp_path / "out"

    def times(**options: Any) -> dict[str, int]:
        rows = by_name(cohort.submit(client, paths, "calibrate", out, **options))
        return {name: os.stat(row["result"]).st_mtime_ns for name, row in rows.items()}

    first = times(gravity=GRAVITY)
    assert times(gravity=GRAVITY) == first
    shutil.copy(sessions[1], paths[1])
    (out / "c.json").unlink()
    second = times(gravity=GRAVITY)
    assert {name for name in first if first[name] != second[name]} == {"b", "c"}
    third = times(gravity=9.81)
    assert all(third[name] != second[name] for name in third)
    # What nobody here wrote is not replaced.
    (out / "a.json").write_text("mine")
    row = by_name(cohort.submit(client, paths, "calibrate", out, gravity=9.80))["a"]
    assert row["error_code"] == "exists"
    assert (out / "a.json").read_text() == "mine"


def test_workers_that_die_and_tasks_that_fail(
    client: Any, sessions: list[Path], program: Program, tmp_path: Path
) -> None:
    names = ["a", "b", "once", "c", "strange", "d"]
    paths = [*copies(sessions[0], tmp_path, *names), tmp_path / "absent.csv"]
    out = tmp_path / "out"

    def codes(window: int | None = None) -> dict[str, Any]:
        rows = by_name(
            cohort.submit(client, paths, "calibrate", out, window=window, gravity=GRAVITY)
        )
        return {name: row["error_code"] for name, row in rows.items()}

    expected = dict.fromkeys(names) | {"strange": "internal", "absent": "not-found"}
    assert codes() == expected
    assert (tmp_path / "once.csv.met").exists(), "no worker died of it"
    # One at a time: Dask may also blame a task that waits in the worker that dies.
    paths += copies(sessions[0], tmp_path, "killer")
    assert codes(window=1) == expected | {"killer": "worker-died"}
    counts = collected(program, out)
    assert (counts["done"], counts["error"], counts["missing"]) == (5, 3, 0)


def test_a_scheduler_that_dies_and_a_new_client(
    sessions: list[Path], program: Program, tmp_path: Path
) -> None:
    names = [f"slow-{i}" for i in range(12)]
    paths = copies(sessions[0], tmp_path, *names)
    out = tmp_path / "out"
    cluster = Cluster(tmp_path)
    client = cluster.client()
    rows = cohort.submit(client, paths, "calibrate", out, gravity=GRAVITY)
    before = [next(rows)["name"], next(rows)["name"]]
    with pytest.raises(gravical.UsageError) as two:
        cohort.submit(client, paths, "calibrate", out, gravity=GRAVITY)
    assert two.value.code == "in-use"
    cluster.scheduler.kill()
    with pytest.raises(gravical.MachineError) as lost:
        before += [row["name"] for row in rows]
    assert lost.value.code == "engine-lost"
    client.close()
    cluster.end()
    counts = collected(program, out)
    assert counts["items"] == 12 and counts["missing"] >= 1
    done = {name: os.stat(out / f"{name}.json").st_mtime_ns for name in before}
    cluster = Cluster(tmp_path)
    client = cluster.client()
    after = by_name(cohort.submit(client, paths, "calibrate", out, gravity=GRAVITY))
    client.shutdown()
    cluster.end()
    assert after.keys() == set(names)
    assert {row["status"] for row in after.values()} == {"done"}
    assert done == {name: os.stat(out / f"{name}.json").st_mtime_ns for name in before}
    assert collected(program, out)["done"] == 12


def limited(bytes: int) -> None:
    """As a disk with so little room for each file."""
    _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bytes if bytes else hard, hard))


@pytest.mark.parametrize("room", [4096, 100])
def test_a_disk_that_is_full(
    client: Any, sessions: list[Path], program: Program, tmp_path: Path, room: int
) -> None:
    # 4096: the row fits, the result does not. 100: neither does, and the client has the row.
    paths = copies(sessions[0], tmp_path, "a", "b")
    out = tmp_path / "out"
    client.run(limited, room)
    try:
        rows = by_name(cohort.submit(client, paths, "calibrate", out, gravity=GRAVITY))
    finally:
        client.run(limited, 0)
    assert [row["error_code"] for row in rows.values()] == ["io", "io"]
    assert not list(out.glob("*.json"))
    assert collected(program, out)["error"] == 2
    rows = by_name(cohort.submit(client, paths, "calibrate", out, gravity=GRAVITY))
    assert {row["status"] for row in rows.values()} == {"done"}
    counts = collected(program, out)
    assert (counts["done"], counts["error"]) == (2, 0)


def test_rows_that_nobody_takes_are_cancelled(
    client: Any, sessions: list[Path], tmp_path: Path
) -> None:
    names = [f"slow-{i}" for i in range(40)]
    paths = copies(sessions[0], tmp_path, *names)
    rows = cohort.submit(client, paths, "calibrate", tmp_path / "out", gravity=GRAVITY)
    next(rows)
    rows.close()  # type: ignore[attr-defined]
    time.sleep(1.5)
    # What waited is gone, and a run may begin again.
    assert len(list((tmp_path / "out").glob("slow-*.json"))) < 10
    cohort.Run(paths, "calibrate", tmp_path / "out", gravity=GRAVITY).close()


def test_wrong_calls(tmp_path: Path, sessions: list[Path]) -> None:
    calls: list[tuple[str, dict[str, Any], str]] = [
        ("motion", {}, "usage"),
        ("calibrate", {"gyro": "g.csv"}, "each-option"),
        ("calibrate", {"gravity": object()}, "usage"),
        ("check", {}, "usage"),
        ("check", {"calibration": tmp_path / "absent.json"}, "not-found"),
    ]
    for task, options, code in calls:
        with pytest.raises(gravical.Error) as wrong:
            cohort.Run(sessions, task, tmp_path / "out", **options)
        assert wrong.value.code == code
    assert not (tmp_path / "out").exists()
    with cohort.Run(sessions[:1], "calibrate", tmp_path / "out", no_such=1) as run:
        row = run.take(0, cohort.work(run.task(0)))
    assert row["error_code"] == "internal" and "no_such" in row["reason"]
