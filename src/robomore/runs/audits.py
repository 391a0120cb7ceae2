"""The audit that lies beside a policy of a run (`robomore audit`)."""

from __future__ import annotations

import logging
from pathlib import Path

from robomore.errors import InputError, RoboMoReError
from robomore.runs.loading import load_run
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
        places = f"{folder.artifacts.name}/{evaluation.artifact}", folder.champion.name
        # `robomore audit RUN/champion` keeps its audit beside the champion's copy of the policy.
        kept = [one for place in places if (one := load_audit(folder.files, f"{place}/{AUDIT}"))]
        if not kept:
            return None
        digest = run.load_policy(evaluation.key).digest
    except InputError:
        return None  # nothing is trained, so nothing is audited
    except ValueError as error:
        log.warning("the audit in %s cannot be used: %s", run.folder, error)
        return None
    for found in kept:
        if found.policy == digest:
            return found
    log.warning("the audit in %s is of another policy; audit again", run.folder)
    return None


def audit_beside(champion: Path, policy: str) -> Audit | None:
    """Return the audit that a run keeps of the policy in its folder `champion/`.

    Args:
        champion: a folder with a design, which need not belong to a run.
        policy: `MLPPolicy.digest` of the policy in it.
    """
    run = RunFolder(champion.resolve().parent)
    if champion.resolve() != run.champion or not run.manifest.is_file():
        return None
    try:
        found = audit_of(load_run(run.path))
    except RoboMoReError as error:
        log.warning("the audit in %s cannot be used: %s", run.path, error)
        return None
    return found if found is not None and found.policy == policy else None
