"""Options and commands of the program, in the words of Python.

The native part speaks of ``--accel-unit`` and of `` `gravical inspect FILE` ``; here that becomes
``accel_unit=`` and ``gravical.inspect("FILE")``. This is the only place that knows of it.
"""

from __future__ import annotations

import re

#: Options of the program that are keyword arguments here, by their names there.
OPTIONS = frozenset(
    """
    accel-unit accel-range gyro-unit gyro-range columns sensor rate time-unit zero-offset axes
    gravity latitude altitude
    gyro method sections rows faces-from turn-angle pose-tilt prior free-pose face-pose thermal
    noise sensor-id sensor-model recorded
    output force keep-raw output-unit
    filter edge channels
    calibration procedure gravity-removal initial-rows smooth zero-velocity rests stances
    stance-rate v0 p0 clock-error tilt-change no-bands
    truth truth-columns truth-align truth-offset
    full spacing term part
    to name device-id rotation counts-per-g counts-per-deg-s upper-limit
    free hold continuous rest turn-time duration soak soak-hysteresis gyro-drift distance offset
    move-time seed tilt jitter drop wrong-header raw decimals range low-pass accel-noise gyro-noise
    accel-bias-instability accel-random-walk gyro-bias-instability gyro-random-walk scale-sd
    misalignment bias gyro-scale gyro-bias g-sensitivity temperature-rise temperature-time
    temperature-drift
    """.split()
)

#: Commands of the program that are functions here.
VERBS = frozenset(
    "inspect calibrate apply denoise motion noise simulate check compare".split()
)

_SHORT = {"-c": "--calibration", "-o": "--output", "-f": "--filter"}
_UNIT = r"(?:m/s\^2|rad/s|deg/s|counts|mg|g|ms|us|ns|s)"
_VALUE = rf"-?\d+(?:\.\d+)?(?![\w.,]*\d)|{_UNIT}(?![\w/])|[A-Z]+(?:_[A-Z]+)*(?![\w])|\w+=[^\s`;)]*"
_OPTION = re.compile(
    rf"(?<![\w-])(--[a-z][a-z0-9-]*|-[cof](?=[\s;,.)`]|$))(?:[ =]({_VALUE}))?"
)
_COMMAND = re.compile(r"`gravical ([a-z]+)((?: [^`]*)?)`")


def in_python(text: str) -> str:
    """The text with keyword arguments in place of options, and functions in place of commands."""
    text = text.replace("motion --causal", "gravical.Motion").replace("--verbose", "report()")
    return _OPTION.sub(_keyword, _COMMAND.sub(_call, text))


def _keyword(match: re.Match[str]) -> str:
    option, value = match.group(1), match.group(2)
    name = _SHORT.get(option, option)[2:]
    if name not in OPTIONS:
        return match.group(0)
    return f"{name.replace('-', '_')}={_literal(value) if value else ''}"


def _call(match: re.Match[str]) -> str:
    verb, rest = match.group(1), match.group(2).split()
    if verb not in VERBS:
        return match.group(0)
    arguments: list[str] = []
    keyword: str | None = None
    for word in rest:
        word = _SHORT.get(word, word)
        if word.startswith("--"):
            if keyword:
                arguments.append(f"{keyword}=True")
            keyword = word[2:].replace("-", "_")
        elif keyword:
            arguments.append(f"{keyword}={_literal(word)}")
            keyword = None
        else:
            arguments.append(_literal(word))
    if keyword:
        arguments.append(f"{keyword}=True")
    return f"`gravical.{verb}({', '.join(arguments)})`"


def _literal(word: str) -> str:
    try:
        float(word)
    except ValueError:
        # A place to fill in, as HZ, stays one.
        return word if re.fullmatch("[A-Z_]+", word) else f'"{word}"'
    return word
