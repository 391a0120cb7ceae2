"""Skips what needs a machine with all sandbox layers, which is tried out once."""

from __future__ import annotations

import pytest

from robomore.errors import InputError
from robomore.sandbox.call import Containment
from robomore.sandbox.layers import ensure


def _possible() -> bool:
    try:
        ensure(Containment.STRICT)
    except InputError:
        return False
    return True


STRICT = _possible()
"""Whether this machine offers the layers that strict containment requires."""

strictly = pytest.mark.skipif(not STRICT, reason="no strict containment on this machine")
