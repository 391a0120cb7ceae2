"""Every error that a user can meet: one line that names the value, the range and the remedy."""

from __future__ import annotations


class RoboMoReError(Exception):
    """Base of all errors that RoboMoRe raises on purpose."""


class InputError(RoboMoReError):
    """The user asked for something that cannot be done; nothing was started and nothing was lost.

    The command line prints it as one line and exits with status 2.
    """


class InvalidMorphology(InputError):
    """Parameters that the task refuses: wrong count, out of bounds, or against one of its rules."""


class InvalidReward(InputError):
    """A reward text that does not parse or does not define `_get_rew(self, x_velocity, action)`."""


class RunFolderError(InputError):
    """A run folder that cannot be used: unwritable, damaged, of another task, or in use."""


class LedgerError(InputError):
    """The ledger is damaged, or was written by another version of RoboMoRe."""


class LedgerDamaged(LedgerError):
    """A file that is not what was written: SQLite cannot read it, or a row is not its digest's."""


class StorageFailed(RoboMoReError):
    """The disk is full, or cannot be written any more; what was finished before is kept."""


class ProposalFailed(RoboMoReError):
    """A designer could not fill a slot, and why. The search asks for a fresh proposal."""


class NoWorker(RoboMoReError):
    """No worker process can be started on this machine; what was finished before is kept."""


class UnfitWorker(RoboMoReError):
    """This machine cannot do the job as the run needs it done; another one may. The job is sound.

    It lacks a sandbox layer, or has other versions of packages or of the task.
    """


class BudgetExhausted(RoboMoReError):
    """A request, token or cost budget is spent; the run stops cleanly and can be resumed."""


class TimeLimitReached(RoboMoReError):
    """The run's time is up: nothing new is started, and everything finished is in the ledger."""


class Interrupted(RoboMoReError):
    """The user stopped the run (Ctrl-C); everything finished so far is in the ledger."""


class RewardFailed(RoboMoReError):
    """A designer's reward raised, or gave something that is not a finite number, while training.

    The message is the diagnosis that goes back to the designer: what happened, in which line, and
    in which state.
    """


class UnstableSimulation(RoboMoReError):
    """The physics diverged (a warning of MuJoCo or a non-finite state)."""


class NothingTrained(RoboMoReError):
    """Every candidate failed; the message counts the reasons and quotes the most frequent one."""


class ModelUnavailable(RoboMoReError):
    """An LLM did not answer after bounded retries; run again to go on from where it stopped."""


class TrainingDiverged(RoboMoReError):
    """A weight or a loss of the trainer is no longer a finite number."""


class ExportFailed(RoboMoReError):
    """What was made for export is not what it should be; nothing was written."""


class VideoFailed(RoboMoReError):
    """A video could not be rendered to its end; nothing was written."""


class FitnessFailed(RoboMoReError):
    """The fitness of a task raised, or gave a number that is not finite: the task's fault."""
