"""Exchanges in the ledger: kept at once, found again by another process, damage never believed."""

from __future__ import annotations

import signal
import sqlite3
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import pytest

from robomore.errors import LedgerError
from robomore.llm import Exchange, Message, Request, Sampling, Spending
from robomore.store import Ledger, LedgerExchanges
from robomore.types import Slot

ASKED = (Message("system", "be brief"), Message("user", "a body?", (b"\x89PNG\x00",)))


def exchange(number: int) -> Exchange:
    return Exchange(
        key=f"key{number}",
        slot=Slot("coarse", "morphology", (number,)),
        repair=0,
        model="fake",
        messages=ASKED,
        sampling=Sampling(temperature=0.3),
        reply="{}",
        input_tokens=100,
        output_tokens=10,
        cost=None if number % 2 else 0.25,
        tries=2,
    )


@pytest.fixture
def path(tmp_path: Path) -> Path:
    Ledger(tmp_path / "ledger.sqlite").close()
    return tmp_path / "ledger.sqlite"


def test_exchanges_come_back_in_order_pictures_and_all(path: Path) -> None:
    log = LedgerExchanges(path)
    for number in (2, 0, 1):
        log.add(exchange(number))
    log.close()
    again = LedgerExchanges(path, read_only=True)
    assert again.all() == [exchange(2), exchange(0), exchange(1)]
    assert again.find("key1") == exchange(1)
    assert again.find("none") is None


def test_validation_errors_are_set_without_losing_the_order(path: Path) -> None:
    log = LedgerExchanges(path)
    for number in range(3):
        log.add(exchange(number))
    log.set_errors("key0", ["too thin"])
    log.set_errors("key1", ())
    found = LedgerExchanges(path).all()
    assert [one.key for one in found] == ["key0", "key1", "key2"]
    assert [one.validation_errors for one in found] == [("too thin",), (), None]
    assert replace(found[0], validation_errors=None) == exchange(0)
    with pytest.raises(KeyError):
        log.set_errors("none", ())


def test_what_was_spent_counts_earlier_processes_too(path: Path) -> None:
    first = LedgerExchanges(path)
    first.add(exchange(0))
    first.close()
    log = LedgerExchanges(path)
    assert log.spent() == Spending(requests=2, tokens=110, cost=0.25)
    log.add(exchange(1))
    assert log.spent() == Spending(requests=4, tokens=220, cost=0.25, unpriced=1)
    assert log.spent() == Spending.of(log.all())


def test_a_changed_row_is_refused_not_believed(path: Path) -> None:
    log = LedgerExchanges(path)
    log.add(exchange(0))
    log.close()
    with sqlite3.connect(path) as db:
        db.execute("UPDATE exchanges SET body = CAST(replace(body, '0.25', '0.01') AS BLOB)")
    with pytest.raises(LedgerError, match="digest"):
        LedgerExchanges(path).find("key0")


def test_it_lives_beside_the_ledger_and_takes_many_threads(path: Path) -> None:
    ledger, log = Ledger(path), LedgerExchanges(path)

    def both(number: int) -> None:
        log.add(exchange(number))
        log.set_errors(f"key{number}", [str(number)])

    with ThreadPoolExecutor(4) as threads:
        futures = [threads.submit(both, number) for number in range(24)]
        for number in range(24):
            ledger.add_event("meanwhile", number=number)
        for future in futures:
            future.result()
    assert {one.validation_errors for one in log.all()} == {(str(number),) for number in range(24)}
    assert log.spent() == Spending.of(log.all())
    assert len(ledger.events()) == 24


def test_an_exchange_outlives_its_process(path: Path) -> None:
    program = textwrap.dedent(
        """
        import os, signal, sys
        from pathlib import Path
        sys.path.insert(0, sys.argv[2])
        from test_exchanges import exchange
        from robomore.store import LedgerExchanges
        LedgerExchanges(Path(sys.argv[1])).add(exchange(0))
        os.kill(os.getpid(), signal.SIGKILL)
        """
    )
    command = [sys.executable, "-c", program, str(path), str(Path(__file__).parent)]
    assert subprocess.run(command, check=False).returncode == -signal.SIGKILL
    assert LedgerExchanges(path).all() == [exchange(0)]


def test_requests_that_were_never_answered_are_counted_for_good(path: Path) -> None:
    asked = Request(Slot("coarse", "morphology", 0, 0), 1, ASKED)
    log = LedgerExchanges(path)
    for _ in range(5):
        log.sent(asked)
    log.add(exchange(0))  # took two of them
    log.close()
    again = LedgerExchanges(path)
    assert again.spent() == Spending(requests=5, tokens=110, cost=0.25)
    again.sent(asked)
    again.sent(asked)
    again.add(exchange(2))
    assert again.spent().requests == 7
    assert [event.body["repair"] for event in Ledger(path).events()] == [1] * 7
