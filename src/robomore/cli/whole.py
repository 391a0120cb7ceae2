"""The type of options that take a whole number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token

from robomore.errors import InputError


def _read(_: Any, tokens: Sequence[Token]) -> int:
    """Return the number that was given; the command line's library would round any other.

    Raises:
        InputError: it is no whole number.
    """
    (token,) = tokens
    try:
        return int(token.value)
    except ValueError:
        said = f"{token.keyword or 'a number'} is {token.value}"
        raise InputError(f"{said}; give a whole number") from None


Whole = Annotated[int, Parameter(converter=_read)]
