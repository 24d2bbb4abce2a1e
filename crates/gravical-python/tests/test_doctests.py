"""The examples in the docstrings."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import gravical
import pytest

MODULES = [name for _, name, _ in pkgutil.iter_modules(gravical.__path__) if name != "_gravical"]


@pytest.mark.parametrize("name", ["", *MODULES])
def test_examples(name: str, calibration: gravical.Calibration) -> None:
    module = importlib.import_module(f"gravical.{name}" if name else "gravical")
    names = {**vars(module), "gravical": gravical, "calibration": calibration}
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    for test in doctest.DocTestFinder(exclude_empty=True).find(module, extraglobs=names):
        result = doctest.DocTestRunner(optionflags=flags).run(test)
        assert result.failed == 0, test.name


def test_everything_is_documented() -> None:
    for name in gravical.__all__:
        if name == "__version__":
            continue
        thing = getattr(gravical, name)
        assert thing.__doc__, name
        if isinstance(thing, type):
            for attribute, value in vars(thing).items():
                if not attribute.startswith("_") and (callable(value) or isinstance(value, property)):
                    assert value.__doc__, f"{name}.{attribute}"
