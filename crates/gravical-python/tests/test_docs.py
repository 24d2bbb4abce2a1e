"""The code in the documents runs as it stands there."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

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


def test_the_page_names_what_there_is(root: Path) -> None:
    import gravical

    text = (root / "docs/python.md").read_text()
    for name in re.findall(r"gravical\.([A-Za-z_]+)", text):
        assert hasattr(gravical, name) or name in ("md",), name
