"""Counts the items of the crate `gravical` in its documentation: its face stays one that a reader sees at once."""

import re
import sys

MOST = 150

page = open(f"{sys.argv[1]}/doc/gravical/all.html", encoding="utf-8").read()
items = re.findall(r'href="[\w/]*\b(?:struct|enum|fn|trait|type|constant|macro)\.\w+\.html">([\w:]+)<', page)
print(f"gravical: {len(items)} public items of at most {MOST}")
sys.exit(len(items) > MOST)
