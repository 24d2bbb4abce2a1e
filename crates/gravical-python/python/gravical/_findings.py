"""Findings and verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Finding:
    """What is odd in a recording or a result.

    Attributes
    ----------
    kind : str
        Stable name: ``unit-mismatch``, ``torn-line`` …; all are in ``docs/recording.md``.
    severity : str
        ``"note"``: the result does not suffer. ``"warning"``: it may.
    message : str
        What was found, with numbers, and what was done.
    file : str or None
        The file or recording; None if it concerns all of them.
    lines : tuple of (int, int)
        Ranges of lines from 1, both ends included; the first 64 of them.
    count : int
        Number of lines, cells or samples in all.
    """

    kind: str
    severity: str
    message: str
    file: str | None = None
    lines: tuple[tuple[int, int], ...] = ()
    count: int = 0

    @property
    def is_warning(self) -> bool:
        """True if the result may suffer."""
        return self.severity == "warning"

    def __str__(self) -> str:
        place = f"{self.file}: " if self.file else ""
        return f"{self.kind}: {place}{self.message}"

    @classmethod
    def _all(cls, found: Iterable[Mapping[str, Any]]) -> tuple[Finding, ...]:
        return tuple(
            cls(
                kind=one["kind"],
                severity=one["severity"],
                message=one["message"],
                file=one["file"],
                lines=tuple((first, last) for first, last in one["lines"]),
                count=one["count"],
            )
            for one in found
        )


class Verdict(str):
    """A judgement in a word, which is the text itself, with its reasons.

    Attributes
    ----------
    reasons : tuple of str
        Why.

    Examples
    --------
    >>> verdict = Verdict("poor", ["the sensor moved"])
    >>> verdict == "poor", verdict.reasons
    (True, ('the sensor moved',))
    """

    reasons: tuple[str, ...]

    def __new__(cls, word: str, reasons: Iterable[str] = ()) -> Verdict:
        verdict = super().__new__(cls, word)
        verdict.reasons = tuple(reasons)
        return verdict

    def __repr__(self) -> str:
        return f"Verdict({str(self)!r}, {list(self.reasons)!r})"
