"""Prints the table of attempts against outcomes."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    reports = [
        report
        for outcome in ("passed", "failed")
        for report in terminalreporter.stats.get(outcome, [])
        if "breaches" in dict(report.user_properties)
    ]
    if not reports:
        return
    terminalreporter.section("hostile programs")
    tests: dict[str, list[Any]] = {}
    for report in reports:
        tests.setdefault(report.nodeid.partition("[")[0].rpartition("::")[2], []).append(report)
    for test, of_it in sorted(tests.items()):
        rows = {it.nodeid.partition("[")[2][:-1]: dict(it.user_properties) for it in of_it}
        if config.get_verbosity() > 0:
            for name, facts in sorted(rows.items()):
                terminalreporter.write_line(
                    f"{name:36} {facts['attempt'][:52]:53} check: {facts['check']:8} "
                    f"{facts['outcome']:15} got across: {facts['breaches']}"
                )
        outcomes = Counter(facts["outcome"] for facts in rows.values())
        across = sum(facts["breaches"] != "none" for facts in rows.values())
        said = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
        terminalreporter.write_line(f"{test}: {len(rows)} programs: {said}; got across: {across}")
