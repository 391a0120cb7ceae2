"""A table of a study, as Markdown, LaTeX and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import dataclass

from robomore.runs.words import number

Entry = str | float | int | None

_LATEX = str.maketrans(
    {
        "&": r"\&",
        "%": r"\%",
        "#": r"\#",
        "_": r"\_",
        "$": r"\$",
        "{": r"\{",
        "}": r"\}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "\\": r"\textbackslash{}",
        "³": r"$^3$",
    }
)


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of texts and numbers.

    Attributes:
        name: of its files.
        title: one sentence on what it shows.
        columns: names, units among them.
        rows: an entry for each column; `None` where there is nothing to tell.
        note: what a reader has to know to read it right.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Entry, ...], ...]
    note: str = ""

    def markdown(self) -> str:
        """Return title, table and note as Markdown; without rows, title and note alone."""
        lines = [f"**{self.title}**"]
        if self.rows:
            lines += ["", _line(self.columns), _line(["---"] * len(self.columns))]
        lines += [_line([_text(entry) for entry in row]) for row in self.rows]
        return "\n".join([*lines, *(["", self.note] if self.note else []), ""])

    def latex(self) -> str:
        """Return the table as LaTeX, for the package `booktabs`."""
        first, *others = self.columns
        lines = [
            f"% {self.title}",
            rf"\begin{{tabular}}{{l{'r' * len(others)}}}",
            r"\toprule",
            _latex_line([first, *others]),
            r"\midrule",
            *(_latex_line([_text(entry) for entry in row]) for row in self.rows),
            r"\bottomrule",
            r"\end{tabular}",
        ]
        return "\n".join([*lines, *([f"% {self.note}"] if self.note else []), ""])

    def csv(self) -> str:
        """Return the rows as CSV, with every digit, and a line of names first."""
        file = io.StringIO(newline="")
        writer = csv.writer(file)
        writer.writerows([self.columns, *(["" if e is None else e for e in r] for r in self.rows)])
        return file.getvalue()


def _text(entry: Entry) -> str:
    if isinstance(entry, float):
        return number(entry)
    return "-" if entry is None else str(entry)


def _line(texts: Sequence[str]) -> str:
    return f"| {' | '.join(text.replace('|', '/') for text in texts)} |"


def _latex_line(texts: Sequence[str]) -> str:
    return " & ".join(text.translate(_LATEX) for text in texts) + r" \\"
