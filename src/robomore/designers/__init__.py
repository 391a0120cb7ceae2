"""Designers: they propose morphologies and rewards, and improve on what was measured.

`Designer` is all that the search knows. `OfflineDesigner` needs no language model, `LLMDesigner`
asks one. `make_designer` returns a designer by its name. `LanguageModel` and `Replay` describe the
designers that need settings. A designer is a pure function of its arguments and its seed, so a run
can be resumed, repeated and spread over processes.
"""

from __future__ import annotations

from robomore.designers.designer import Designer
from robomore.designers.registry import DESIGNERS, LanguageModel, Replay, make_designer

__all__ = ["DESIGNERS", "Designer", "LanguageModel", "Replay", "make_designer"]
