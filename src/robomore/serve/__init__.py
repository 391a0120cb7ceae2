"""The live page: all runs of a folder in a browser, up to date while they go on.

It only reads: run folders, their ledgers and what a run tells of its progress. `application` is a
Starlette application, `serve` runs it. `robomore serve` is the command.
"""

from robomore.serve.app import application
from robomore.serve.running import serve

__all__ = ["application", "serve"]
