"""The audit that lies beside a policy of a run (`robomore audit`)."""

from __future__ import annotations

import logging

from robomore.errors import InputError
from robomore.runs.run import Run
from robomore.store import RunFolder
from robomore.store.audit import AUDIT, Audit, load_audit

log = logging.getLogger(__name__)


def audit_of(run: Run, key: str | None = None) -> Audit | None:
    """Return the audit of an evaluation's policy, by default of the champion's best seed.

    Whoever made the folder made the audit: run it again where you do not trust them.

    Args:
        run: whose folder is looked into.
        key: of the evaluation.

    Returns:
        `None` if there is none, or none of the policy that lies there now.
    """
    try:
        evaluation = run.kept(key)
        if not evaluation.artifact:
            return None
        folder = RunFolder(run.folder)
        found = load_audit(folder.files, f"{folder.artifacts.name}/{evaluation.artifact}/{AUDIT}")
        if found is None:
            return None
        if found.policy != run.load_policy(evaluation.key).digest:
            log.warning("the audit in %s is of another policy; audit again", run.folder)
            return None
    except InputError:
        return None  # nothing is trained, so nothing is audited
    except ValueError as error:
        log.warning("the audit in %s cannot be used: %s", run.folder, error)
        return None
    return found
