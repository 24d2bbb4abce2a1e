"""Results: the document of the program, with its report and figures."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any

from . import _gravical, _notebook
from ._errors import usage
from ._findings import Finding, Verdict
from ._types import Path

if TYPE_CHECKING:
    from typing_extensions import Self


@dataclass(frozen=True)
class Figure:
    """A figure of a result.

    Attributes
    ----------
    name : str
        Stable name, as the program's files of ``--figures``.
    title, caption : str
        What it shows.
    svg : str
        The figure.
    """

    name: str
    title: str
    caption: str
    svg: str

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write the figure as SVG. Nothing is overwritten without ``force``."""
        _gravical.write_text(path, self.svg, force)


class _Kept:
    """Report and figures of a result that came through a pickle."""

    def __init__(self, figures: list[tuple[str, str, str, str]], texts: dict[str, str]) -> None:
        self._figures, self._texts = figures, texts

    def figures(self) -> list[tuple[str, str, str, str]]:
        return self._figures

    def document(self, format: str) -> str:
        return self._texts[format]


_FORMATS = ("summary", "text", "markdown", "html")


class Result:
    """Base class of all results.

    ``str(result)`` is the report of the program in short; a notebook shows it with its figures.
    """

    _native: Any

    def __init__(self, native: Any, document: dict[str, Any] | None = None) -> None:
        self._native = native
        if document is not None:
            self._dict = document

    @cached_property
    def _dict(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads(self._native.json())
        return document

    @classmethod
    def _of(cls, outcome: _gravical.Outcome) -> Self:
        return cls(outcome)

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the program (``--json``): same names, same numbers, same texts."""
        return dict(self._dict)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is odd."""
        return Finding._all(self._dict.get("findings", ()))

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures of the report."""
        return tuple(Figure(*drawn) for drawn in self._native.figures())

    def report(self, path: Path | None = None, *, force: bool = False) -> str:
        """The report, as the program writes it with ``--report``.

        Parameters
        ----------
        path : path, optional
            File to write: ``.html`` for a page with everything in it, ``.md`` for Markdown, ``.txt``
            for text.
        force : bool
            Overwrite an existing file.

        Returns
        -------
        str
            The report: without ``path`` as text.
        """
        if path is None:
            return str(self._native.document("text"))
        ending = os.path.splitext(os.fspath(path))[1].lower()
        formats = {".html": "html", ".htm": "html", ".md": "markdown", ".txt": "text"}
        if ending not in formats:
            raise usage(
                f"a report is not written as {ending or 'a file without an ending'}",
                "name a file that ends in .html, .md or .txt",
                code="report-target",
            )
        text = str(self._native.document(formats[ending]))
        _gravical.write_text(path, text, force)
        return text

    def __str__(self) -> str:
        # The program shows the rest with an option.
        text = str(self._native.document("summary")).rstrip()
        return text.replace("(--verbose)", "(report())")

    def __repr__(self) -> str:
        return f"<{type(self).__name__}{self._brief()}>"

    def _brief(self) -> str:
        return ""

    def _repr_html_(self) -> str:
        return _notebook.page(type(self).__name__, str(self), self.figures)

    def __getstate__(self) -> dict[str, Any]:
        texts = {name: self._native.document(name) for name in _FORMATS}
        kept = _Kept(self._native.figures(), texts)
        return {**self.__dict__, "_dict": self._dict, "_native": kept}


class Judged(Result):
    """A result with a verdict."""

    @property
    def verdict(self) -> Verdict:
        """The verdict, a text such as ``"fits"``, with its ``reasons``."""
        verdict = self._dict["verdict"]
        return Verdict(verdict.get("judgement") or verdict["grade"], verdict["reasons"])

    def _brief(self) -> str:
        return f": {self.verdict}"


class Inspection(Result):
    """What is in a recording: :func:`gravical.inspect`."""

    def _brief(self) -> str:
        return f" of {self._dict['file']!r}" if "file" in self._dict else ""


class CheckReport(Judged):
    """Whether a calibration still fits: :func:`gravical.check`. Its verdict is ``"fits"``,
    ``"does-not-fit"`` or ``"undecided"``."""

    @property
    def static_intervals(self) -> list[dict[str, Any]]:
        """Each static interval with its error."""
        return list(self._dict["static_intervals"])


class Comparison(Judged):
    """Whether two calibrations differ: :func:`gravical.compare`. Its verdict is ``"agree"``,
    ``"differ"`` or ``"undecided"``."""


class NoiseResult(Result):
    """Noise of a sensor: :func:`gravical.noise`."""

    @property
    def channels(self) -> dict[str, dict[str, Any]]:
        """Each channel (``ax`` … ``gz``) with its Allan deviation ``adev`` and the estimates ``n``,
        ``b`` and ``k`` with 95 % intervals, None where the recording does not determine them."""
        return {channel["channel"]: channel for channel in self._dict["channels"]}

    def save(self, path: Path, *, force: bool = False) -> None:
        """Write the JSON that ``calibrate(noise=…)`` and ``motion(noise=…)`` take."""
        text = json.dumps(self._dict, indent=2, ensure_ascii=False) + "\n"
        _gravical.write_text(path, text, force)

    def to_kalibr(self, *, upper_limit: bool = False) -> str:
        """The ``imu.yaml`` of Kalibr; ``upper_limit`` takes upper limits for what is not
        determined."""
        if not isinstance(self._native, _gravical.Outcome):
            raise usage("this result came through a pickle", "export where it was computed")
        return self._native.kalibr(upper_limit)[0]


class ApplySummary(Result):
    """What :func:`gravical.apply` did from file to file."""

    def __init__(self, document: dict[str, Any]) -> None:
        lines = f"{document['input']}: {document['rows']} rows calibrated"
        page = f"<p>{escape(lines)}</p>"
        texts = {name: page if name == "html" else lines for name in _FORMATS}
        super().__init__(_Kept([], texts), document)

    @property
    def rows(self) -> int:
        """Rows that were written."""
        return int(self._dict["rows"])
