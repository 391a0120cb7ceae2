"""Designers: whoever proposes bodies and rewards, and improves on what was measured.

`Designer` is all that the search knows. `OfflineDesigner` needs no LLM, `HumanDesigner` and
`RandomDesigner` are baselines; `make_designer` returns one by its name. `LanguageModel` and
`Replay` say what is to design where a name is not enough. A designer is a pure function of its
arguments and its seed, so a run can be resumed, repeated and spread over processes.
"""

from __future__ import annotations

from robomore.designers.designer import Designer
from robomore.designers.registry import DESIGNERS, LanguageModel, Replay, make_designer

__all__ = ["DESIGNERS", "Designer", "LanguageModel", "Replay", "make_designer"]
