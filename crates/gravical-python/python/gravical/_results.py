"""Results: the document of the program, with its report and figures."""

from __future__ import annotations

import json
import os
from base64 import b64encode
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import Any

from . import _gravical
from ._errors import usage
from ._findings import Finding, Verdict
from ._types import Path


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


class Result:
    """Base class of all results.

    ``str(result)`` is the report of the program in short; a notebook shows it with its figures.
    """

    #: None after a pickle, which keeps the numbers and the report in short.
    _native: Any

    def __init__(self, native: Any) -> None:
        self._native = native

    @cached_property
    def _dict(self) -> dict[str, Any]:
        document: dict[str, Any] = json.loads(self._native.json())
        return document

    @cached_property
    def _summary(self) -> str:
        # The program shows the rest with an option.
        return str(self._native.document("summary")).rstrip().replace("(--verbose)", "(report())")

    def _computed(self) -> Any:
        """The native part, for what a pickle does not keep."""
        if self._native is None:
            raise usage(
                "this result holds its numbers alone",
                "reports and tables are written where it is computed; a pickle does not keep them",
            )
        return self._native

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the program (``--json``): same names, same numbers, same texts."""
        return dict(self._dict)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is odd."""
        return Finding._all(self._dict.get("findings", ()))

    @property
    def figures(self) -> tuple[Figure, ...]:
        """The figures of the report; none after a pickle."""
        drawn = [] if self._native is None else self._native.figures()
        return tuple(Figure(*figure) for figure in drawn)

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
        native = self._computed()
        if path is None:
            return str(native.document("text"))
        ending = os.path.splitext(os.fspath(path))[1].lower()
        formats = {".html": "html", ".htm": "html", ".md": "markdown", ".txt": "text"}
        if ending not in formats:
            raise usage(
                f"a report is not written as {ending or 'a file without an ending'}",
                "name a file that ends in .html, .md or .txt",
                code="report-target",
            )
        text = str(native.document(formats[ending]))
        _gravical.write_text(path, text, force)
        return text

    def __str__(self) -> str:
        return self._summary

    def __repr__(self) -> str:
        return f"<{type(self).__name__}{self._brief()}>"

    def _brief(self) -> str:
        return ""

    def _repr_html_(self) -> str:
        # Images cannot disturb the page around them.
        figures = "".join(
            f'<figure><img alt="{escape(figure.title)}" src="data:image/svg+xml;base64,'
            f'{b64encode(figure.svg.encode()).decode()}">'
            f"<figcaption>{escape(figure.caption)}</figcaption></figure>"
            for figure in self.figures
        )
        return f"<div><pre>{escape(str(self))}</pre>{figures}</div>"

    def __getstate__(self) -> dict[str, Any]:
        kept = {"_dict": self._dict, "_summary": self._summary, "_native": None}
        return {**vars(self), **kept}


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
        return str(self._computed().kalibr(upper_limit))


class ApplySummary(Result):
    """What :func:`gravical.apply` did from file to file."""

    def __init__(self, document: dict[str, Any]) -> None:
        super().__init__(None)
        self._dict = document
        self._summary = f"{document['input']}: {document['rows']} rows calibrated"

    @property
    def rows(self) -> int:
        """Rows that were written."""
        return int(self._dict["rows"])
