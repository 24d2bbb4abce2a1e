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

SCHEMAS = Path(__file__).parents[3] / "docs"

HEAD = '''"""Keywords of the functions, and the documents of results; written by tests/make_types.py."""

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


#: What a written calibration says besides, which its schema leaves out since it is not read.
READABLE: dict[str, dict[str, str]] = {
    "CalibrationDocument": {"verdict": "Verdict"},
    "Accelerometer": {"scale": "list[float]", "orientation": "list[list[float]]", "deviations": "Deviations | None"},
    "Deviations": dict.fromkeys(("bias", "scale", "axis_angle_deg"), "list[float]"),
    "Verdict": {"grade": 'Literal["good", "fair", "not-verifiable", "poor"]', "reasons": "list[str]"},
}

PLAIN = {"number": "float", "integer": "int", "boolean": "bool", "string": "str", "null": "None", "object": "dict[str, Any]"}


def _schema_type(schema: dict[str, Any]) -> str:
    """The type of what a JSON schema describes."""
    if "$ref" in schema:
        return str(schema["$ref"]).rsplit("/", 1)[1]
    if "const" in schema or "enum" in schema:
        return f"Literal[{', '.join(json.dumps(v) for v in schema.get('enum', [schema.get('const')]))}]"
    if parts := schema.get("anyOf") or schema.get("oneOf"):
        return " | ".join(dict.fromkeys(map(_schema_type, parts)))
    kinds = schema.get("type", [])
    items = _schema_type(schema["items"]) if isinstance(schema.get("items"), dict) else "Any"
    names = [kinds] if isinstance(kinds, str) else kinds
    return " | ".join(f"list[{items}]" if kind == "array" else PLAIN[kind] for kind in names) or "Any"


def _documents() -> str:
    """A class for each object of the files, an alias for what is none."""
    classes: dict[str, str] = {}
    for file, title in (("calibration-3", "Calibration"), ("noise-1", "Noise")):
        schema = json.loads((SCHEMAS / f"gravical-{file}.schema.json").read_text(encoding="utf-8"))
        for name, of in {**schema["$defs"], f"{title}Document": schema}.items():
            rows = {key: _schema_type(part) for key, part in of.get("properties", {}).items()}
            classes[name] = _typed_dict(name, {**rows, **READABLE.get(name, {})})
            if not rows:
                classes[name] = f"\n{name} = {_schema_type(of)}\n"
    classes.update((n, _typed_dict(n, READABLE[n])) for n in ("Deviations", "Verdict"))
    return "".join(classes.values())


def _typed_dict(name: str, rows: dict[str, str]) -> str:
    return f"\nclass {name}(TypedDict):\n" + "".join(f"    {k}: {v}\n" for k, v in rows.items())


def text() -> str:
    """The file."""
    types = {verb: {name: _type(verb, name) for name in _names(verb)} for verb in VERBS}
    types["simulate"] = {n: _type(s, n) for s in SCENARIOS for n in _names(s)}
    types["denoise"].pop("filter")
    types["read"] = types["noise"]
    types["samples"] = {name: kind for name, kind in types["read"].items() if name != "gyro"}
    return HEAD + "".join(_options(verb.title(), of) for verb, of in types.items()) + _documents()


if __name__ == "__main__":
    TARGET.write_text(text(), encoding="utf-8")
