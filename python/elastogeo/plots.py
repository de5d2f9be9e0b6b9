"""Tables and SVG plots for notebooks: small, and without a plotting library."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from typing import Any

_ROW, _LEFT, _WIDTH = 18, 130, 520
_INK, _BAR = "#4269d0", "#9fb4e8"


def _svg(title: str, body: str, height: float) -> str:
    words = f'<text x="0" y="14" font-weight="bold">{html.escape(title)}</text>'
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_LEFT + _WIDTH + 70}" height="{height:.0f}" '
        f'font-family="sans-serif" font-size="12" fill="currentColor" role="img" aria-label="{html.escape(title)}">'
        f"{words}{body}</svg>"
    )


def _name(row: int, name: str) -> str:
    return f'<text x="{_LEFT - 6}" y="{34 + row * _ROW}" text-anchor="end">{html.escape(name)}</text>'


def bars(title: str, values: Sequence[tuple[str, float]]) -> str:
    """Horizontal bars from 0.

    >>> bars("shares", [("joint:2", 0.5)]).count("<rect")
    1
    """
    greatest = max((abs(value) for _, value in values), default=0.0)
    if not values or greatest == 0:
        return ""
    body = ""
    for row, (name, value) in enumerate(values):
        width = _WIDTH * abs(value) / greatest
        y = 24 + row * _ROW
        body += _name(row, name) + f'<rect x="{_LEFT}" y="{y}" width="{width:.1f}" height="12" fill="{_BAR}"/>'
        body += f'<text x="{_LEFT + width + 4:.1f}" y="{y + 10}">{value:.3g}</text>'
    return _svg(title, body, 34 + _ROW * len(values))


def intervals(title: str, values: Sequence[tuple[str, float, float | None]]) -> str:
    """Values with the half widths of their intervals, about 0.

    >>> intervals("changes", [("2.d", -0.1, 0.05)]).count("<circle")
    1
    """
    known = [(name, value, width or 0.0) for name, value, width in values if math.isfinite(value)]
    greatest = max((abs(value) + width for _, value, width in known), default=0.0)
    if greatest == 0:
        return ""
    middle, size = _LEFT + _WIDTH / 2, _WIDTH / 2 / greatest
    bottom = 28 + _ROW * len(known)
    body = f'<line x1="{middle}" x2="{middle}" y1="22" y2="{bottom}" stroke="currentColor" stroke-opacity=".4"/>'
    for row, (name, value, width) in enumerate(known):
        x, y = middle + value * size, 30 + row * _ROW
        body += _name(row, name)
        body += f'<line x1="{x - width * size:.1f}" x2="{x + width * size:.1f}" y1="{y}" y2="{y}" stroke="{_INK}"/>'
        body += f'<circle cx="{x:.1f}" cy="{y}" r="3" fill="{_INK}"/>'
        body += f'<text x="{_LEFT + _WIDTH + 8}" y="{y + 4}">{value:.3g}</text>'
    return _svg(title, body, bottom + 8)


def histogram(title: str, values: Sequence[float], count: int = 20) -> str:
    """How often values lie where, from 0 to the greatest.

    >>> histogram("errors", [0.1, 0.2, 0.9]).count("<rect")
    20
    """
    greatest = max(values, default=0.0)
    if greatest <= 0:
        return ""
    often = [0] * count
    for value in values:
        often[min(count - 1, int(value / greatest * count))] += 1
    width, body = _WIDTH / count, ""
    for k, many in enumerate(often):
        tall = 100 * many / max(often)
        body += f'<rect x="{k * width:.1f}" y="{124 - tall:.1f}" width="{width - 1:.1f}" height="{tall:.1f}" fill="{_BAR}"/>'
    body += f'<text x="0" y="140">0</text><text x="{_WIDTH}" y="140" text-anchor="end">{greatest:.3g}</text>'
    return _svg(title, body, 148)


def decades(title: str, values: Sequence[float]) -> str:
    """Values above 0 one after another, on a logarithmic scale.

    >>> decades("singular values", [3.0, 0.5, 2e-4]).count("<circle")
    3
    """
    known = [value for value in values if 0 < value < math.inf]
    if not known:
        return ""
    high = math.ceil(math.log10(max(known)))
    low = min(high - 1, math.floor(math.log10(min(known))))
    tall, step = 140 / (high - low), _WIDTH / len(known)
    body = ""
    for power in range(low, high + 1):
        y = 28 + (high - power) * tall
        body += f'<line x1="{_LEFT}" x2="{_LEFT + _WIDTH}" y1="{y:.1f}" y2="{y:.1f}" stroke="currentColor" stroke-opacity=".2"/>'
        body += f'<text x="{_LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">1e{power}</text>'
    for k, value in enumerate(known):
        y = 28 + (high - math.log10(value)) * tall
        body += f'<circle cx="{_LEFT + (k + 0.5) * step:.1f}" cy="{y:.1f}" r="3" fill="{_INK}"/>'
    return _svg(title, body, 184)


def table(rows: Sequence[dict[str, Any]]) -> str:
    """Rows as an HTML table.

    >>> table([{"name": "2.d", "value": 0.25}])
    '<table><tr><th>name</th><th>value</th></tr><tr><td>2.d</td><td>0.25</td></tr></table>'
    """
    if not rows:
        return ""

    def cell(value: object) -> str:
        return html.escape(f"{value:.6g}" if isinstance(value, float) else "" if value is None else str(value))

    head = "".join(f"<th>{html.escape(str(name))}</th>" for name in rows[0])
    body = "".join("<tr>" + "".join(f"<td>{cell(v)}</td>" for v in row.values()) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"
