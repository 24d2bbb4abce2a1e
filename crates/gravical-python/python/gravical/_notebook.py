"""Results in a notebook: the report in short, and the figures."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable
from html import escape
from typing import Protocol


class Drawn(Protocol):
    """A figure."""

    @property
    def title(self) -> str: ...
    @property
    def caption(self) -> str: ...
    @property
    def svg(self) -> str: ...


_BLOCK = (
    "font-family: ui-monospace, monospace; font-size: 0.85em; line-height: 1.35;"
    " white-space: pre-wrap; margin: 0 0 0.8em 0"
)


def page(kind: str, text: str, figures: Iterable[Drawn]) -> str:
    """HTML without scripts; figures are images, which cannot disturb the page around them."""
    parts = [f'<pre style="{_BLOCK}">{escape(text)}</pre>']
    parts += [_figure(figure) for figure in figures]
    return f'<div class="gravical" aria-label="{escape(kind)}">{"".join(parts)}</div>'


def _figure(figure: Drawn) -> str:
    data = b64encode(figure.svg.encode()).decode()
    return (
        '<figure style="margin: 0 0 1.2em 0">'
        f'<img alt="{escape(figure.title)}" style="max-width: 100%; background: white"'
        f' src="data:image/svg+xml;base64,{data}">'
        f'<figcaption style="font-size: 0.85em; max-width: 60em">{escape(figure.caption)}'
        "</figcaption></figure>"
    )
