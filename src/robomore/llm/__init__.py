"""Language models behind one small interface, and the log of every exchange with them.

A `ChatModel` answers a `Request` with a `Completion`. The designer uses it only through a
`BudgetedClient`: an exchange that the log already holds is not paid for again, and a new one is
counted against the budget and logged before it is read. This package knows nothing of tasks and
robots. It imports no provider's library before `connect` is called.
"""

from robomore.llm.budgeted_client import BudgetedClient, ModelBudget
from robomore.llm.exchange import Exchange, ExchangeLog, MemoryLog, Spending, exchange_key
from robomore.llm.model import ChatModel, Completion, Message, Request, Sampling
from robomore.llm.providers import connect
from robomore.llm.replay import ReplayModel
from robomore.llm.selfcheck import check

__all__ = [
    "BudgetedClient",
    "ChatModel",
    "Completion",
    "Exchange",
    "ExchangeLog",
    "MemoryLog",
    "Message",
    "ModelBudget",
    "ReplayModel",
    "Request",
    "Sampling",
    "Spending",
    "check",
    "connect",
    "exchange_key",
]
