"""A run before people and scripts: read from its folder alone.

`write_report` writes the page of a run, one HTML file that needs nothing else, `write_comparison`
one of several runs; `as_data` is a run's JSON form, which `robomore show --json` prints.
"""

from robomore.report.comparison import write_comparison
from robomore.report.json_export import as_data
from robomore.report.page import write_report

__all__ = ["as_data", "write_comparison", "write_report"]
