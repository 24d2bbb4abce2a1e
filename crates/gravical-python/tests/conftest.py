"""What the tests share."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gravical
import pytest

ROOT = Path(__file__).resolve().parents[3]

Program = Callable[..., Any]


@pytest.fixture(scope="session")
def root() -> Path:
    """The repository."""
    return ROOT


@pytest.fixture(scope="session")
def examples() -> Path:
    return ROOT / "examples"


@pytest.fixture(scope="session")
def program() -> Program:
    """The program, whose JSON is returned; exit code 4 is a verdict. Path: GRAVICAL_BIN."""
    binary = os.environ.get("GRAVICAL_BIN")
    if not binary:
        if os.environ.get("CI"):
            pytest.fail("GRAVICAL_BIN does not name the program")
        pytest.skip("GRAVICAL_BIN does not name the program")

    def run(*arguments: Any, parse: bool = True) -> Any:
        words = [binary, *map(str, arguments)]
        done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT)
        if not parse:
            assert done.returncode in (0, 4), done.stderr
            return done.stdout
        return json.loads(done.stdout)

    return run


@pytest.fixture(scope="session")
def data() -> Path:
    """The real recordings."""
    folder = os.environ.get("GRAVICAL_DATA")
    if not folder:
        pytest.skip("GRAVICAL_DATA does not name the folder of real recordings")
    return Path(folder)


@pytest.fixture(scope="session")
def poses() -> gravical.Recording:
    """Six faces and eight free poses."""
    made: gravical.Recording = gravical.simulate("poses", free=8, seed=3).recordings["poses.csv"]
    return made


@pytest.fixture(scope="session")
def line() -> gravical.Recording:
    """A move of 0.7 m of the same sensor."""
    made: gravical.Recording = gravical.simulate("line", seed=3).recordings["line.csv"]
    return made


@pytest.fixture(scope="session")
def calibration(poses: gravical.Recording) -> gravical.Calibration:
    return gravical.calibrate(poses, gravity=9.80665)
