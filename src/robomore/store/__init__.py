"""What a run leaves behind: one folder, and in it one ledger that everything is read back from.

`RunFolder` is the one place that knows file names, `Manifest` says what was asked for, and `Ledger`
remembers every proposal, evaluation and exchange as it happens.
"""

from robomore.store.ledger import Ledger
from robomore.store.manifest import Manifest, package_versions
from robomore.store.rundir import RunFolder

__all__ = ["Ledger", "Manifest", "RunFolder", "package_versions"]
