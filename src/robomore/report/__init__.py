"""A run before people and scripts: read from its folder alone.

`write_report` writes the page of a run, one HTML file that needs nothing else, `write_comparison`
one of several runs; `as_data` is a run's JSON form, which `robomore show --json` prints;
`notebook_html` is what a notebook shows of a run.
"""

from robomore.report.comparison import write_comparison
from robomore.report.json_export import as_data
from robomore.report.notebook import notebook_html
from robomore.report.page import write_report

__all__ = ["as_data", "notebook_html", "write_comparison", "write_report"]
