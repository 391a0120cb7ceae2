"""Designers: whoever proposes bodies and rewards, and improves on what was measured.

`Designer` is all that the search knows. `OfflineDesigner` needs no LLM, `HumanDesigner` and
`RandomDesigner` are baselines; `make_designer` returns one by its name. A designer is a pure
function of its arguments and its seed, so a run can be resumed, repeated and spread over processes.
"""

from __future__ import annotations

from robomore.designers.designer import Designer
from robomore.designers.registry import DESIGNERS, make_designer

__all__ = ["DESIGNERS", "Designer", "make_designer"]
