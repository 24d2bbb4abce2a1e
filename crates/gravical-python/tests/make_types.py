"""Write ``python/gravical/_types.pyi``: the keywords of each function, with their types, as the native part
takes them. It is asked for each: which names a verb accepts, and what it says of a value of no type.

    python tests/make_types.py
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from gravical import _gravical

TARGET = Path(__file__).parent.parent / "python/gravical/_types.pyi"

HEAD = '''"""Keywords of the functions, written by tests/make_types.py."""

import datetime
import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict, Union

Path = Union[str, "os.PathLike[str]"]
Paths = Union[Path, Sequence[Path]]
Text = Union[str, Sequence[Any], Mapping[str, Any]]
'''

#: What the native part expects, and the type of that.
TYPES = {
    "a number": "float",
    "a whole number in its range": "int",
    "a boolean": "bool",
    "a sequence": "Paths",
    "a path": "Path",
    "path string": "Path",
    "a text": "str",
}

#: What it takes as a text of its own form, or of any.
TEXTS = {"recorded": "Union[str, datetime.date]", "sections": "Path", "sensor": "Union[str, int]"}

VERBS = ("inspect", "calibrate", "apply", "denoise", "noise", "check", "motion", "orient")
SCENARIOS = ("six-position", "poses", "static", "line")


def _call(verb: str, **given: Any) -> str:
    """What is said of these keywords and one that does not exist."""
    keywords = json.dumps({**given, "no such": 1})
    try:
        if verb in SCENARIOS:
            _gravical.simulate(verb, "nowhere", False, keywords)
        else:
            _gravical.run(verb, ["nowhere"], [], None, keywords)
    except Exception as error:
        return str(error)
    raise AssertionError(verb)


def _names(verb: str) -> list[str]:
    return _call(verb).split("accepted: ")[1].split(", ")


def _type(verb: str, name: str) -> str:
    said = _call(verb, **{name: {"?": [[None]]}}).split("\n")[0]
    if "unknown variant" in said:
        values = re.findall("`([^`]+)`", said.split("expected")[1])
        return f"Literal[{', '.join(json.dumps(v) for v in values if v != 'unknown')}]"
    expected = next((t for words, t in TYPES.items() if said.endswith(f"expected {words}")), None)
    if expected:
        return expected
    is_text = said.startswith("unexpected keyword")
    return TEXTS.get(name, "str" if is_text else "Text")


def _options(title: str, types: dict[str, str]) -> str:
    rows = "".join(f"    {name}: {kind} | None\n" for name, kind in sorted(types.items()))
    return f"\nclass {title}Options(TypedDict, total=False):\n{rows}"


def text() -> str:
    """The file."""
    types = {verb: {name: _type(verb, name) for name in _names(verb)} for verb in VERBS}
    types["simulate"] = {n: _type(s, n) for s in SCENARIOS for n in _names(s)}
    types["denoise"].pop("filter")
    types["read"] = types["noise"]
    types["samples"] = {name: kind for name, kind in types["read"].items() if name != "gyro"}
    return HEAD + "".join(_options(verb.title(), of) for verb, of in types.items())


if __name__ == "__main__":
    TARGET.write_text(text(), encoding="utf-8")
