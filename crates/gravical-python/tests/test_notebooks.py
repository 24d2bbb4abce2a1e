"""The notebooks run from the top to the bottom, and show what they speak of.

The pages are written to GRAVICAL_NOTEBOOKS, if that names a folder.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

FOLDER = Path(__file__).resolve().parents[1] / "notebooks"


def executed(name: str) -> Any:
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    for cell in notebook.cells:
        assert not cell.get("outputs"), "outputs are not part of the repository"
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    target = os.environ.get("GRAVICAL_NOTEBOOKS")
    if target:
        nbconvert = pytest.importorskip("nbconvert")
        page, _ = nbconvert.HTMLExporter().from_notebook_node(notebook)
        Path(target).mkdir(parents=True, exist_ok=True)
        (Path(target) / f"{name}.html").write_text(page)
    return notebook


def shown(notebook: Any) -> tuple[str, str]:
    """All texts, and all HTML."""
    texts, pages = [], []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            texts.append(output.get("text", ""))
            data = output.get("data", {})
            texts.append(data.get("text/plain", ""))
            pages.append(data.get("text/html", ""))
    return "\n".join(texts), "\n".join(pages)


def test_six_placements() -> None:
    texts, pages = shown(executed("six_placements"))
    assert "not-verifiable" in texts and "good" in texts
    assert pages.count("<img") >= 8 and "bounded" in pages
    assert "within the stated uncertainty: True" in texts


def test_phone(data: Path) -> None:
    texts, pages = shown(executed("phone"))
    assert "74." in texts and pages.count("<img") >= 2
