"""Keywords are typed: programs with a mistake fail before they run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import make_types
import pytest

RIGHT = """import gravical
cal = gravical.calibrate("session", latitude=48.1, method="ferraris", thermal=["soak.csv"])
bias: list[float] = cal.document["accelerometer"]["bias"]
good: bool = cal.document["verdict"]["grade"] == "good"
gravical.apply(cal, "walk.csv", output="out.csv", output_unit="g", rate=None)
gravical.motion("line.csv", cal, rests=[(0, 5), (7.2, None)], no_stances=True)
gravical.simulate("poses", free=8, seed=3, rate=50)
"""

#: A keyword that does not exist, a unit that does not, a text for a number, and a key that does not exist.
WRONG = {
    "lattitude": 'gravical.calibrate("session", lattitude=48.1)',
    "gram": 'gravical.read("walk.csv", accel_unit="gram")',
    "acelerometer": 'gravical.calibrate("session").document["acelerometer"]',
    "100 Hz": 'gravical.noise("rest.csv", rate="100 Hz")',
}


def test_the_types_are_those_of_the_native_part() -> None:
    written = make_types.TARGET.read_text(encoding="utf-8")
    assert written == make_types.text(), "run tests/make_types.py"


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_programs_with_a_mistake_fail(checker: str, tmp_path: Path) -> None:
    (tmp_path / "right.py").write_text(RIGHT)
    for i, line in enumerate(WRONG.values()):
        (tmp_path / f"wrong{i}.py").write_text(f"import gravical\n{line}\n")
    python = ["--pythonpath", sys.executable] if checker == "pyright" else []
    command = [sys.executable, "-m", checker, *python, "."]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True).stdout
    lines = [line for line in said.splitlines() if "error" in line and ".py:" in line]
    assert not [line for line in lines if "right.py" in line], said
    for i, _ in enumerate(WRONG):
        assert any(f"wrong{i}.py:2" in line for line in lines), said
