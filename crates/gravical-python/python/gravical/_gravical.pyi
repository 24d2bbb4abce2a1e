"""The native part, see src/: documents and keywords are JSON, a calibration has its name beside it."""

from typing import Any

__version__: str
READING: list[str]

def __getattr__(name: str) -> Any: ...
