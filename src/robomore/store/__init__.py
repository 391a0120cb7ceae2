"""What a run leaves behind: one folder, and in it one ledger that everything is read back from.

`RunFolder` is the one place that knows file names, `Manifest` says what was asked for, and `Ledger`
remembers every proposal and evaluation as it happens. `LedgerExchanges` keeps, in the same file,
what was said to a language model.
"""

from robomore.store.exchanges import LedgerExchanges
from robomore.store.ledger import Ledger
from robomore.store.manifest import Manifest, package_versions
from robomore.store.recovery import open_or_recover
from robomore.store.rundir import RunFolder, refuse_no_folder

__all__ = [
    "Ledger",
    "LedgerExchanges",
    "Manifest",
    "RunFolder",
    "open_or_recover",
    "package_versions",
    "refuse_no_folder",
]
