"""What a run leaves behind: one folder, and in it one ledger that everything is read back from.

`RunFolder` is the one place that knows file names, `Manifest` says what was asked for, and `Ledger`
remembers every proposal and evaluation as it happens. `LedgerExchanges` keeps, in the same file,
what was said to a language model.
"""

from robomore.store.exchanges import LedgerExchanges
from robomore.store.ledger import Ledger
from robomore.store.manifest import Manifest, package_versions
from robomore.store.rundir import RunFolder
from robomore.store.salvage import whole_ledger

__all__ = ["Ledger", "LedgerExchanges", "Manifest", "RunFolder", "package_versions", "whole_ledger"]
