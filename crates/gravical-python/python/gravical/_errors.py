"""Exceptions: what happened, where, and what to do next."""

from __future__ import annotations


class Error(Exception):
    """Base class of all errors of this package.

    ``message`` says what happened, with the numbers, and ``hint`` what to do next, or is None.
    ``code`` stays the same for programs: ``missing-face``, ``unit-unknown`` …; all are in
    ``docs/recording.md``. ``file``, ``line`` and ``column``, from 1, are the place, if it is known.
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
        self.message, self.code, self.hint = message, code, hint
        self.file, self.line, self.column = file, line, column

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
