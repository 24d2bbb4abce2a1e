#!/usr/bin/env python3
"""Checks that imports inside a crate point down: no circle of modules, at any depth of folders, and no
more arrows up than before.

    tests/rooms.py crates/gravical/src ...

A room is a file or a folder of modules. Paths that begin with `crate::` or `super::` count, those of
tests do not; a module and its own parts are one room. An arrow up is an import of a part from a module
that it is a part of, or from the root of the crate.
"""

import pathlib
import re
import sys


def without_tests(text):
    """The text without comments and without what only tests compile; lists inside lists of names are left out."""
    text = re.sub(r"//.*", "", text)
    item = r"(?ms)^( *)#\[cfg\(test\)\]\n(?:\1#.*?\n)*\1\S[^\n]*?(?:;\n|\{\n.*?^\1\}\S*\n)"
    text = re.sub(item, "", text)
    inner = r"(::\{[^{}]*?\b\w+)::\{[^{}]*\}"
    while re.search(inner, text):
        text = re.sub(inner, r"\1", text)
    return text


def targets(text, module):
    """Paths from the root of the crate, one for each name of a list in braces."""
    for root, path, last in re.findall(r"(?<!\$)\b(crate|super(?:::super)*)::((?:\w+::)*)(\w+\b(?!!)|\{[^{}]*\})", text):
        if root != "crate":
            above = module[: -(root.count("super"))]
            path = "".join(f"{name}::" for name in above) + path
        for name in last.strip("{}").split(","):
            yield path + name.strip()


def module(path):
    """The module of a file."""
    parts = path.with_suffix("").parts
    return parts[:-1] if parts[-1] == "mod" else parts


def imports(files, depth):
    """Which room imports which, with a file that does."""
    rooms = {module(path)[:depth] for path in files}
    found = {}
    for path, text in files.items():
        own = module(path)[:depth]
        for target in targets(text, module(path)):
            names = tuple(target.split("::"))[:depth]
            while names and names not in rooms:
                names = names[:-1]
            related = names[: len(own)] == own or own[: len(names)] == names
            if names and not related:
                found.setdefault(own, {})[names] = path
    return found


def circle(found):
    """A circle of rooms; None if there is none."""
    done = set()

    def visit(room, above):
        if room in above:
            return above[above.index(room) :]
        if room in done:
            return None
        for other in found.get(room, ()):
            if around := visit(other, [*above, room]):
                return around
        done.add(room)
        return None

    return next((c for c in (visit(room, []) for room in list(found)) if c), None)


# Arrows up that are left; what is not named has none.
LEFT = {
    "gravical": 164,
    "gravical-calibrate": 88,
    "gravical-cli": 6,
    "gravical-core": 6,
    "gravical-fit": 6,
    "gravical-report": 52,
}


def arrows_up(files):
    """Imports of parts from the modules around them."""
    rooms = {module(path) for path in files}
    for path, text in files.items():
        own = module(path)
        for target in targets(text, own):
            names = tuple(target.split("::"))
            while names and names not in rooms:
                names = names[:-1]
            if len(names) < len(own) and own[: len(names)] == names:
                yield f"{path}: {target}"


def main():
    failed = False
    for source in map(pathlib.Path, sys.argv[1:]):
        files = {
            path.relative_to(source): without_tests(path.read_text())
            for path in source.rglob("*.rs")
            if path.name not in ("tests.rs", "lib.rs", "main.rs") and "tests" not in path.parts
        }
        if not files:
            sys.exit(f"{source}: no files")
        up = list(arrows_up(files))
        print(f"{source}: {len(up)} arrows up")
        if len(up) > LEFT.get(source.parent.name, 0):
            failed = True
            print("  more than were left:", *up, sep="\n    ")
        for depth in (1, 2, 3):
            found = imports(files, depth)
            arrows = sum(map(len, found.values()))
            print(f"{source}: depth {depth}, {arrows} imports between modules")
            if around := circle(found):
                failed = True
                print("  a circle:")
                for room, other in zip(around, [*around[1:], around[0]]):
                    print(f"    {'::'.join(room)} -> {'::'.join(other)} in {found[room][other]}")
    sys.exit(failed)


if __name__ == "__main__":
    main()
