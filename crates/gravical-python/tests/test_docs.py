"""The code in the documents runs as it stands there."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import gravical
import pytest


@pytest.mark.parametrize("name", ["docs/python.md", "crates/gravical-python/README.md"])
def test_the_blocks_of_a_page(name: str, root: Path, tmp_path: Path) -> None:
    blocks = re.findall(r"(?ms)^```python\n(.*?)^```", (root / name).read_text())
    assert blocks
    script = tmp_path / "page.py"
    script.write_text("\n".join(blocks))
    # As a script: process pools start from one. Warnings of exports are expected.
    words = [sys.executable, "-W", "ignore", str(script)]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("engine", ["distributed", "ray", "pyspark"])
def test_the_recipes_of_the_engines(engine: str, root: Path, tmp_path: Path) -> None:
    pytest.importorskip(engine, reason=f"{engine} is not installed: its recipe was not run")
    if engine == "pyspark" and not shutil.which("java"):
        pytest.skip("Spark needs Java: its recipe was not run")
    blocks = re.findall(r"(?ms)^```python\n(.*?)^```", (root / "docs/cohorts.md").read_text())
    [block] = [b for b in blocks if re.search(rf"^(from|import) {engine}\b", b, re.M)]
    paths = []
    for seed in range(1, 4):
        made = gravical.simulate("poses", free=8, seed=seed, output=tmp_path / f"unit-{seed}")
        paths.append(made.paths[0])
    (tmp_path / "list.txt").write_text("\n".join([*paths, "absent.csv"]))
    script = tmp_path / "recipe.py"
    script.write_text(block)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYSPARK_PYTHON": sys.executable}
    words = [sys.executable, str(script)]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env=env, timeout=120)
    assert done.returncode == 0, done.stderr
    said = sorted(line.split()[-1] for line in done.stdout.splitlines())
    assert said == ["good", "good", "good", "not-found"]
    [out] = tmp_path.glob("out-*")
    assert len(list(out.glob("*.json"))) == 3


def test_the_page_names_what_there_is(root: Path) -> None:
    import gravical

    text = (root / "docs/python.md").read_text()
    for name in re.findall(r"gravical\.([A-Za-z_]+)", text):
        assert hasattr(gravical, name) or name in ("md",), name
