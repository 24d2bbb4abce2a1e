"""Keywords for the native part, which knows their names, defaults and what they take."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from ._errors import UsageError

Path = Union[str, "os.PathLike[str]"]
Floats = npt.NDArray[np.float64]


def is_path(value: Any) -> bool:
    """True for what names a file."""
    return isinstance(value, (str, os.PathLike))


def keywords(given: Mapping[str, Any]) -> str:
    """The keywords as JSON, without those that are None."""
    plain = {name: _plain(name, value) for name, value in given.items() if value is not None}
    return json.dumps(plain)


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        if math.isfinite(value):
            return value
        raise UsageError(f"{name}=: {value} is not finite")
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, Mapping):
        return {str(key): _plain(name, part) for key, part in value.items()}
    if hasattr(value, "isoformat"):
        return value.isoformat()
    if isinstance(value, Iterable) and not isinstance(value, (bytes, bytearray)):
        return [_plain(name, part) for part in value]
    raise UsageError(f"{name}=: a {type(value).__name__} is no option")
