"""Amounts that depend on free parameters: polynomials, written as a template's placeholders."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_NEGLIGIBLE = 1e-9
"""A coefficient below this is rounding: lengths are in m, masses in kg."""

_ONE = 1e-6
"""A factor so close to 1 is 1."""


class Amount:
    """A sum of numbers times products of parameters, such as `0.02 + 0.5 * thigh_length`.

    `numpy` arrays of them (with `dtype=object`) can be added and multiplied.
    """

    def __init__(self, terms: Mapping[tuple[str, ...], float]) -> None:
        """Hold a sum.

        Args:
            terms: the factor of each product; a product is the sorted names in it, `()` is 1.
        """
        self.terms = {names: factor for names, factor in terms.items() if factor}

    @classmethod
    def of(cls, value: Amount | float) -> Amount:
        """Return `value`, a number or an amount, as an amount."""
        return value if isinstance(value, Amount) else cls({(): float(value)})

    def __add__(self, other: Amount | float) -> Amount:
        terms = dict(self.terms)
        for names, factor in Amount.of(other).terms.items():
            terms[names] = terms.get(names, 0.0) + factor
        return Amount(terms)

    def __mul__(self, other: Amount | float) -> Amount:
        terms: dict[tuple[str, ...], float] = {}
        for names, factor in self.terms.items():
            for others, times in Amount.of(other).terms.items():
                product = tuple(sorted(names + others))
                terms[product] = terms.get(product, 0.0) + factor * times
        return Amount(terms)

    __radd__ = __add__
    __rmul__ = __mul__

    def __neg__(self) -> Amount:
        return self * -1.0

    def __sub__(self, other: Amount | float) -> Amount:
        return self + -Amount.of(other)

    def __rsub__(self, other: Amount | float) -> Amount:
        return -self + other

    def text(self, negligible: float = _NEGLIGIBLE) -> str:
        """Return the amount as it stands in a template: a plain number, or `{…}`.

        Args:
            negligible: factors below are left out.
        """
        terms = {n: f for n, f in self.terms.items() if abs(f) > negligible}
        if not set(terms) - {()}:
            return _number(terms.get((), 0.0))
        parts = []
        for names, factor in sorted(terms.items()):
            product = "*".join(names)
            if names and abs(abs(factor) - 1) < _ONE:
                parts.append(product if factor > 0 else f"-{product}")
            else:
                parts.append("*".join(filter(None, [_number(factor), product])))
        return "{" + " + ".join(parts).replace("+ -", "- ") + "}"


def texts(amounts: Iterable[Amount | float], negligible: float = _NEGLIGIBLE) -> str:
    """Return the value of an attribute that holds several amounts."""
    return " ".join(Amount.of(amount).text(negligible) for amount in amounts)


def _number(value: float) -> str:
    return f"{value:.9g}"
