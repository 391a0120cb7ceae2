"""How different proposals are: numbers by their variation, texts by the words they share."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from statistics import fmean, stdev

_TOKEN = re.compile(r"\w+|[^\w\s]")
_COMMENT = re.compile(r"#.*")
_ORDER = 4
_ROUNDING = 1e-9
"""A mean this small beside the column's largest value is 0 but for rounding."""


def coefficient_of_variation(rows: Sequence[Sequence[float]]) -> float:
    """Return the standard deviation over the size of the mean, averaged over the columns.

    The paper measures the diversity of morphologies by it (its Table 3). It takes columns that have
    one sign: where a mean is near 0, that column decides alone, by how near. Columns whose mean is
    0, but for rounding, have none and are left out.

    Args:
        rows: parameters of each morphology, at least two rows.

    Raises:
        ValueError: there are fewer than two rows, or no column has a mean other than 0.
    """
    if len(rows) < 2:
        raise ValueError("a variation needs at least two rows")
    columns = list(zip(*rows, strict=True))
    found = [
        stdev(column) / abs(mean)
        for column in columns
        if abs(mean := fmean(column)) > _ROUNDING * max(map(abs, column))
    ]
    if not found:
        raise ValueError("no column has a mean other than 0")
    return fmean(found)


def tokens(text: str) -> list[str]:
    """Return the words, numbers and signs of a program text without its comments, in order."""
    return _TOKEN.findall(_COMMENT.sub("", text))


def self_bleu(texts: Sequence[Sequence[str]]) -> float:
    """Return the mean BLEU of each text against all others, in [0, 1]; less is more diverse.

    The paper measures the diversity of rewards by it (Zhu et al. 2018).

    Args:
        texts: tokens of each text, at least two texts.

    Raises:
        ValueError: there are fewer than two texts.
    """
    if len(texts) < 2:
        raise ValueError("texts are compared with each other: give at least two")
    return fmean(bleu(text, [*texts[:i], *texts[i + 1 :]]) for i, text in enumerate(texts))


def bleu(text: Sequence[str], references: Sequence[Sequence[str]]) -> float:
    """Return the BLEU of one text in [0, 1], by up to four words in a row.

    As sacrebleu computes it for sentences: a length of n-grams that has no match counts as half a
    match, the next one as a quarter, and so on (smoothing "exp"); lengths beyond the text's own do
    not count; a text shorter than the reference of the nearest length is penalised. Where not even
    a word matches, sacrebleu returns 0, and this a small number.

    Args:
        text: tokens.
        references: tokens of each reference, at least one reference.
    """
    if not text:
        return 0.0
    logs: list[float] = []
    misses = 0
    for size in range(1, min(_ORDER, len(text)) + 1):
        counts = _ngrams(text, size)
        most: Counter[tuple[str, ...]] = Counter()
        for reference in references:
            most |= _ngrams(reference, size)
        matches: float = (counts & most).total()
        if not matches:
            misses += 1
            matches = 0.5**misses
        logs.append(math.log(matches / counts.total()))
    nearest = min((abs(len(r) - len(text)), len(r)) for r in references)[1]
    penalty = min(0.0, 1 - nearest / len(text))
    return math.exp(penalty + fmean(logs))


def _ngrams(text: Sequence[str], size: int) -> Counter[tuple[str, ...]]:
    return Counter(tuple(text[i : i + size]) for i in range(len(text) - size + 1))
