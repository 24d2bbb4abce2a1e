"""Exceptions: what happened, where, and what to do next."""

from __future__ import annotations

from typing import Any


class Error(Exception):
    """Base class of all errors of this package.

    Attributes
    ----------
    code : str
        Stable name for programs: ``missing-face``, ``unit-unknown`` …; all of them are in
        ``docs/recording.md``.
    message : str
        What happened and where, with the numbers.
    hint : str or None
        What to do next. Options have the names of the program: ``--pose-tilt`` is ``pose_tilt=``.
    file : str or None
        The file or the name of the recording.
    line, column : int or None
        The place in it, from 1.
    """

    def __init__(
        self,
        message: str,
        code: str = "usage",
        hint: str | None = None,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        super().__init__(message, code, hint, file, line, column)
        self.message = message
        self.code = code
        self.hint = hint
        self.file = file
        self.line = line
        self.column = column

    def __str__(self) -> str:
        hint = f"\n  try: {self.hint}" if self.hint else ""
        return f"{self.message}{hint}\n  code: {self.code}"


class UsageError(Error, ValueError):
    """An argument that is not possible, or that does not fit the others."""


class InputError(Error, ValueError):
    """The recording or file does not hold what is needed."""


class NotFoundError(InputError, FileNotFoundError):
    """There is no such file."""


class ExistsError(UsageError, FileExistsError):
    """A file is there already, and ``force=True`` is not given."""


class MachineError(Error, OSError):
    """The machine: disk, permissions, memory."""


_CLASSES: dict[str, type[Error]] = {
    "not-found": NotFoundError,
    "exists": ExistsError,
    "usage": UsageError,
    "input": InputError,
    "system": MachineError,
}


def raised(category: str, message: str, code: str, *rest: Any) -> Error:
    """The exception for an error of the native part."""
    kind = _CLASSES.get(code) or _CLASSES.get(category, Error)
    return kind(message, code, *rest)
