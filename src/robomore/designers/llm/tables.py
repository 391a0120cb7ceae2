"""Tables in Markdown."""

from __future__ import annotations

from collections.abc import Sequence


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    """Return the lines of a table; a column that is empty in all rows is left out."""
    kept = [i for i in range(len(head)) if any(row[i] for row in rows)] or range(len(head))
    lines = [[cells[i].replace("|", "/") for i in kept] for cells in (head, *rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return ["| " + " | ".join(cells) + " |" for cells in lines]
