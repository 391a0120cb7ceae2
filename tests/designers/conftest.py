"""Lets the tests of designers use the helpers of `tests/designers` and `tests/llm`."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "llm"))
