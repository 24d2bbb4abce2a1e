"""The code in the documents and notebooks runs as it stands there."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

PAGES = [
    "docs/python.md",
    "crates/gravical-python/README.md",
    "crates/gravical-python/notebooks/six_placements.ipynb",
    "crates/gravical-python/notebooks/phone.ipynb",
]
#: Blocks that need what is not always installed, by how they begin.
OPTIONAL = {"distributed": "from distributed", "imucal": "import imucal"}


def code_of(path: Path) -> str:
    if path.suffix == ".md":
        blocks = re.findall(r"(?ms)^```python\n(.*?)^```", path.read_text())
        skipped = tuple(start for name, start in OPTIONAL.items() if not find_spec(name))
        return "\n".join(block for block in blocks if not block.startswith(skipped))
    cells = json.loads(path.read_text())["cells"]
    assert not any(cell.get("outputs") for cell in cells), "outputs are not part of the repository"
    return "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")


@pytest.mark.parametrize("name", PAGES)
def test_the_code_of_a_page(
    name: str, root: Path, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    code = code_of(root / name)
    assert code
    if "GRAVICAL_DATA" in code:
        request.getfixturevalue("data")
    script = tmp_path / "page.py"
    script.write_text(code)
    # As a script: process pools start from one. Warnings of exports are expected.
    words = [sys.executable, "-W", "ignore", str(script)]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, env=env)
    assert done.returncode == 0, done.stderr
