#!/usr/bin/env python3
"""Checks that imports inside a crate point down: no circle of modules, at any depth of folders.

    tests/rooms.py crates/gravical/src ...

A room is a file or a folder of modules. Paths that begin with `crate::` or `super::` count, those of
tests do not; a module and its own parts are one room.
"""

import pathlib
import re
import sys


def without_tests(text):
    """The text without comments and without what only tests compile."""
    text = re.sub(r"//.*", "", text)
    start = text.find("#[cfg(test)]")
    while start >= 0:
        depth, end = 0, start
        while end < len(text):
            if text[end] == "{":
                depth += 1
            elif text[end] == "}":
                depth -= 1
            if depth == 0 and text[end] in "};":
                break
            end += 1
        text = text[:start] + text[end + 1 :]
        start = text.find("#[cfg(test)]")
    return text


def targets(text, module):
    """Paths from the root of the crate, one for each name of a list in braces."""
    for match in re.finditer(r"\b(crate|super(?:::super)*)::((?:\w+::)*)(\w+|\{)", text):
        root, path, last = match.groups()
        if root != "crate":
            above = module[: -(root.count("super"))]
            path = "".join(f"{name}::" for name in above) + path
        if last != "{":
            yield path + last
            continue
        depth, name = 0, ""
        for c in text[match.end() - 1 :]:
            if c == "{":
                depth += 1
            elif c == "}":
                depth -= 1
            if (c == "," and depth == 1) or depth == 0:
                yield path + name.strip()
                name = ""
            elif not (c in "{}" or (depth > 1)):
                name += c
            if depth == 0:
                break


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
