#!/usr/bin/env python3
"""README and docs as HTML, with the gallery: .ci/documents.py FOLDER

Links between documents stay links; those to other files of the repository point to the forge.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import markdown
from release import workspace

ROOT = Path(__file__).resolve().parent.parent
STYLE = """
body { max-width: 50rem; margin: 2rem auto; padding: 0 1rem; font: 1rem/1.5 system-ui, sans-serif; color-scheme: light dark }
pre { overflow-x: auto; padding: .8rem; border: 1px solid #8885; font-size: .85rem } img { max-width: 100% }
table { display: block; overflow-x: auto; border-collapse: collapse } td, th { border: 1px solid #8885; padding: .2rem .5rem }
"""


def anchor(text: str, separator: str) -> str:
    """As the forge names headings, so that links within documents hold."""
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", separator)


def main(out: Path) -> None:
    files = subprocess.run(["git", "ls-files", "README.md", "docs"], cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE)
    names = files.stdout.split()
    pages = {name: re.sub(r"README\.md$", "index.md", name)[:-2] + "html" for name in names if name.endswith(".md")}
    missing = []

    def link(page: str, target: str) -> str:
        path, _, fragment = target.partition("#")
        if not path or "://" in path:
            return target
        name = os.path.normpath(os.path.join(os.path.dirname(page), path))
        if name in names:
            there = os.path.relpath(pages.get(name, name), os.path.dirname(page) or ".")
        elif (ROOT / name).exists():
            there = f"{workspace('repository')}/blob/main/{name}"
        else:
            missing.append(f"{page}: {target}")
            return target
        return there + (f"#{fragment}" if fragment else "")

    for name in names:
        place = out / pages.get(name, name)
        place.parent.mkdir(parents=True, exist_ok=True)
        if name not in pages:
            shutil.copy(ROOT / name, place)
            continue
        text = (ROOT / name).read_text(encoding="utf-8")
        extensions = ["tables", "fenced_code", "toc"]
        body = markdown.markdown(text, extensions=extensions, extension_configs={"toc": {"slugify": anchor}})
        body = re.sub(r'(href|src)="([^"]+)"', lambda m: f'{m[1]}="{link(name, m[2])}"', body)
        title = re.search(r"^# (.+)", text, re.M)[1]
        home = "../" * name.count("/")
        top = f'<p><a href="{home}index.html">gravical</a> · <a href="{home}gravical.html">in the browser</a></p>'
        place.write_text(
            f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
            f"<title>{title}</title><style>{STYLE}</style>{top}\n{body}</html>\n",
            encoding="utf-8",
        )
    if missing:
        sys.exit("links to nothing:\n" + "\n".join(missing))
    print(f"{len(pages)} documents")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
