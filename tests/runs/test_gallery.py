"""A gallery: champions in small folders that need no run."""

from __future__ import annotations

import json
from contextlib import closing
from pathlib import Path

import pytest

from audit.canned import copy_with_canned_audits
from dog import write_dog
from robomore.audit import Subject
from robomore.audit.seeds import REPORTED
from robomore.errors import InputError, RunFolderError
from robomore.experiment import auditing
from robomore.experiment.auditing import audit_run
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task
from robomore.options import settings_words
from robomore.plain_files import PlainFolder
from robomore.runs import load_run
from robomore.runs.gallery import add_entry, load_entry, load_gallery
from robomore.store import Ledger
from robomore.store.audit import Audit, Verdict, save_audit
from robomore.store.champion import write_design, write_sums
from robomore.training.policy import MLPPolicy
from robomore.types import Design, Evaluation, Job, Morphology, Reward, Status, TrainerSettings


@pytest.fixture
def audited(trained_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    run = copy_with_canned_audits(trained_run, tmp_path, monkeypatch)
    audit_run(run)
    return run


def test_an_entry_is_the_champion_without_its_run(audited: Path, tmp_path: Path) -> None:
    run = load_run(audited)
    folder = add_entry(run, tmp_path / "gallery")
    (entry,) = load_gallery(tmp_path / "gallery")
    assert folder == tmp_path / "gallery" / "run" == entry.folder
    champion = run.champion
    assert champion is not None and champion.efficiency is not None
    assert entry.efficiency == champion.efficiency.mean
    assert entry.facts.parameters == champion.parameters
    assert entry.reward == champion.design.reward.source
    assert entry.audit is not None and not entry.audit.passes
    assert entry.origin is not None and entry.origin.seed == 1
    assert entry.origin.role == run.champion_role
    final = entry.origin.final_efficiency
    assert final["found"] == run.found.efficiency.values  # type: ignore[union-attr]
    assert final["reference"] == entry.origin.reference_efficiency
    assert len(final["morphology_only"]) == len(entry.origin.final_fitness["reward_only"])
    assert entry.origin.settings == settings_words(run.manifest.preset, run.manifest.settings)
    assert sum(one.stat().st_size for one in folder.iterdir()) < 2**20
    with pytest.raises(InputError, match="exists"):
        add_entry(run, tmp_path / "gallery")


def test_an_entry_tells_how_rewards_were_contained(audited: Path, tmp_path: Path) -> None:
    with closing(Ledger(audited / "ledger.sqlite")) as ledger:
        ledger.add_event("containment", layers="relaxed (limits;\nwithout files)")
    origin = load_entry(add_entry(load_run(audited), tmp_path / "gallery")).origin
    assert origin is not None and origin.containment == "relaxed (limits; without files)"


def test_what_is_no_champion_is_refused(trained_run: Path, audited: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not audited"):
        add_entry(load_run(trained_run), tmp_path / "gallery")
    with pytest.raises(InputError, match="is no gallery"):
        load_gallery(audited / "artifacts")
    with pytest.raises(InputError, match=r"has no design\.json"):
        load_entry(tmp_path)


@pytest.mark.parametrize("name", ["design.json", "reward.py", "policy.npz", "origin.json"])
def test_a_changed_entry_is_refused(name: str, audited: Path, tmp_path: Path) -> None:
    folder = add_entry(load_run(audited), tmp_path / "gallery")
    (folder / name).write_bytes((folder / name).read_bytes() + b" ")
    with pytest.raises(RunFolderError, match="SHA256SUMS"):
        load_entry(folder)
    (folder / "SHA256SUMS").unlink()
    (folder / name).write_bytes(b"{")
    if name in ("design.json", "origin.json"):
        with pytest.raises(InputError, match="damaged"):
            load_entry(folder)


def test_a_task_that_is_not_here(audited: Path, tmp_path: Path) -> None:
    folder = add_entry(load_run(audited), tmp_path / "gallery")
    (folder / "SHA256SUMS").unlink()
    facts = json.loads((folder / "design.json").read_text())
    (folder / "design.json").write_text(json.dumps({**facts, "task": "swimer"}))
    with pytest.raises(InputError, match="swimer"):
        load_entry(folder)


def test_a_design_of_an_own_task_brings_its_task(tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    task = read_task(write_proposal(read_robot(source), source, tmp_path / "dog"))
    design = Design(Morphology(task.reference), Reward(task.reward))
    job = Job(task.id, design, TrainerSettings("crossq"), 100, 1, 0)
    (tmp_path / "out").mkdir()
    write_design(tmp_path / "out", task, [Evaluation("k", job, Status.OK, fitness=1.0)])
    write_sums(tmp_path / "out")
    entry = load_entry(tmp_path / "out")  # `get_task` knows no task of this id here
    assert entry.task.id == task.id and entry.facts.parameters == task.named(task.reference)
    assert entry.task.mjcf(task.reference) == task.mjcf(task.reference)


def test_an_audit_of_a_design_compares_with_what_it_tells(
    audited: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = add_entry(load_run(audited), tmp_path / "gallery")
    entry = load_entry(folder)
    policy = MLPPolicy.load(folder / "policy.npz")
    design = json.loads((folder / "design.json").read_text())
    (folder / "design.json").write_text(json.dumps({**design, "fitness": [0.5, None, 0.75, 9.0]}))
    told = Verdict("other seeds", "passes", "As told.", {REPORTED: 0.75})
    save_audit(
        PlainFolder(folder),
        "audit.json",
        Audit(entry.task.id, policy.digest, 1, 1.0, 1.0, 1.0, {}, (told,)),
    )
    asked: list[float | None] = []

    def audit(subject: Subject) -> Audit:
        asked.append(subject.reported)
        assert entry.audit is not None
        return entry.audit

    monkeypatch.setattr(auditing, "audit", audit)
    parameters = tuple(entry.facts.parameters.values())
    auditing.audit_design(folder, entry.task, parameters, policy)
    other = MLPPolicy(policy.weights, tuple(bias + 1 for bias in policy.biases))
    auditing.audit_design(folder, entry.task, parameters, other)
    (folder / "design.json").write_text(json.dumps({**design, "fitness": [7.0]}))
    auditing.audit_design(folder, entry.task, parameters, policy)
    (folder / "design.json").write_text(json.dumps(design["parameters"]))
    auditing.audit_design(folder, entry.task, parameters, policy)
    assert asked == [0.75, 9.0, 7.0, None]
