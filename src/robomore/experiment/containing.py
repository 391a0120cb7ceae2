"""How untrusted rewards are kept in during a run, decided before anything starts."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from robomore.sandbox.call import Containment
from robomore.sandbox.layers import ensure
from robomore.sandbox.restrictions import Layer, missing

log = logging.getLogger(__name__)


def choose_containment(asked: str | None, ours: bool) -> tuple[Containment, str]:
    """Return the mode, and in words by which layers of the operating system.

    Args:
        asked: `strict`, `relaxed`, or `None` for what fits.
        ours: whether all rewards come from this package or from the user, none from an LLM.

    Raises:
        InputError: strict containment is asked for, or needed, and not possible here.
    """
    if asked is None and ours:
        found = ensure(Containment.RELAXED)
        possible = not missing(found)
        if not possible:
            log.warning("strict containment is not possible here; `robomore doctor` says why")
        return _described(Containment.STRICT if possible else Containment.RELAXED, found)
    mode = Containment(asked or Containment.STRICT)
    return _described(mode, ensure(mode))


def _described(mode: Containment, found: Sequence[Layer]) -> tuple[Containment, str]:
    on = ", ".join(layer.name for layer in found if layer.active)
    off = ", ".join(layer.name for layer in found if not layer.active)
    return mode, f"{mode} ({on}{f'; without {off}' if off else ''})"
