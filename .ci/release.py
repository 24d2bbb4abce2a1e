#!/usr/bin/env python3
"""Version and consistency checks for a release:

    .ci/release.py version        the version of the workspace
    .ci/release.py rust           the oldest Rust that builds it
    .ci/release.py notes          what CHANGELOG.md says of the version
    .ci/release.py check [TAG]    TAG, CITATION.cff and CHANGELOG.md agree with the version, and no placeholder is left
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def workspace(key: str) -> str:
    return re.search(rf'^{key} = "(.+)"$', read("Cargo.toml"), re.M)[1]


def section(version: str) -> tuple[str, str]:
    """Title and text of the version in the changelog."""
    found = re.search(rf"^## ({re.escape(version)}\b.*)\n((?:(?!^## ).*\n?)*)", read("CHANGELOG.md"), re.M)
    if not found:
        sys.exit(f"CHANGELOG.md has no section {version}")
    return found[1], found[2].strip() + "\n"


def check(tag: str | None) -> list[str]:
    version = workspace("version")
    title, _ = section(version)
    faults = []
    if tag not in (None, f"v{version}"):
        faults.append(f"the tag is {tag}, the version of Cargo.toml {version}")
    if not re.search(r" \(\d{4}-\d{2}-\d{2}\)$", title):
        faults.append(f"CHANGELOG.md: '{title}' has no date: ## {version} (2026-12-31)")
    if f"version: {version}\n" not in read("CITATION.cff"):
        faults.append(f"CITATION.cff: the version is not {version}")
    for name, pinned in re.findall(r'^(gravical\S*) = \{ path = .*version = "([^"]+)"', read("Cargo.toml"), re.M):
        if pinned != version:
            faults.append(f"Cargo.toml: {name} {pinned} is not {version}")
    if "Until this version is released" in section(version)[1]:
        faults.append("CHANGELOG.md: the section still says 'Until this version is released'")
    unpublished = {
        "README.md": "Nothing is published yet",
        "docs/browser.md": "none is out yet",
        "docs/python.md": "pip install ./crates/gravical-python",
    }
    for name, words in unpublished.items():
        if words in read(name):
            faults.append(f"{name} still says '{words}'")
    if "/OWNER/" in workspace("repository"):
        faults.append("Cargo.toml: repository still says OWNER")
    return faults


def main() -> None:
    match sys.argv[1:]:
        case ["version"]:
            sys.stdout.buffer.write(workspace("version").encode() + b"\n")
        case ["rust"]:
            sys.stdout.buffer.write(workspace("rust-version").encode() + b"\n")
        case ["notes"]:
            sys.stdout.write(section(workspace("version"))[1])
        case ["check", *tag]:
            faults = check(tag[0] if tag else None)
            if faults:
                sys.exit("\n".join(faults))
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main()
