"""A run looked back at: read from its folder alone, by people and by scripts.

`summarise` turns a run folder into one frozen `Summary`; `as_data` is its JSON form (what
`robomore show --json` prints), and `write_report` its page: one HTML file that needs nothing else.
"""

from __future__ import annotations

from robomore.report.json_export import as_data
from robomore.report.page import write_report
from robomore.report.summary import Summary, summarise

__all__ = ["Summary", "as_data", "summarise", "write_report"]
