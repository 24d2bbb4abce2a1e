#!/usr/bin/env python3
"""Compares the recordings in a folder with SHA256SUMS: tests/data/check.py FOLDER

A file that differs, or that has no source (SOURCES.md), is an error; one that is absent is not.
"""

import hashlib
import sys
from pathlib import Path


def main(folder: Path) -> int:
    lines = Path(__file__).with_name("SHA256SUMS").read_text().splitlines()
    sums = {name: digest for digest, name in (line.split("  ", 1) for line in lines)}
    sources = Path(__file__).with_name("SOURCES.md").read_text()
    faults = [f"{name}: no set of SOURCES.md" for name in sums if f"`{name.split('/')[0]}`" not in sources]
    found = 0
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_dir() or name == "README.md":
            continue
        if name not in sums:
            faults.append(f"{name}: has no source")
        elif hashlib.sha256(path.read_bytes()).hexdigest() != sums[name]:
            faults.append(f"{name}: is not the file of SHA256SUMS")
        else:
            found += 1
    print("\n".join(faults + [f"{found} of {len(sums)} files are there"]))
    return 1 if faults or not found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
