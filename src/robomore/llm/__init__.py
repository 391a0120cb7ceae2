"""Language models behind one small port, and the record of every exchange with them.

A `ChatModel` answers a `Request` with a `Completion`. A `BudgetedClient` is the one way to it: an
exchange that the log already holds is not paid for again, a new one is counted against the budget
and written down before anybody looks at it. This package knows no tasks and no robots, and imports
no provider's library until a model is connected.
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
