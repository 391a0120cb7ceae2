"""From a robot's file to a task, and what is said of mistakes on the way."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import mujoco
import pytest

from dog import DOG, write_arm, write_dog
from robomore.envs.source import environment_source
from robomore.errors import InputError
from robomore.importer.proposal import write_proposal
from robomore.importer.reading import read_robot
from robomore.importer.task_file import read_task_file
from robomore.tasks import get_task
from robomore.tasks.fingerprint import fingerprint, task_key
from robomore.tasks.portable import task_content, task_from_content
from robomore.testing.tasks import check_task


@pytest.fixture(scope="module")
def dog(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The task file that is proposed for the dog."""
    folder = tmp_path_factory.mktemp("dog")
    source = write_dog(folder)
    return write_proposal(read_robot(source), source, folder / "dog")


def edited(file: Path, old: str, new: str) -> Path:
    text = file.read_text()
    assert old in text
    other = file.with_name(f"edited{abs(hash((old, new)))}.toml")
    other.write_text(text.replace(old, new, 1))
    return other


def test_a_proposed_task_keeps_the_contract(dog: Path) -> None:
    task = get_task(str(dog))
    assert task.names == ("thigh_length", "thigh_radius", "calf_length", "calf_radius")
    assert task.reference == pytest.approx((0.2, 0.02, 0.2, 0.015))
    assert task.mass.startswith("length: ")
    assert get_task("dog") is task, "known by its id in this process"
    check_task(task)


def test_the_proposed_pose_has_the_feet_below_the_hips(dog: Path) -> None:
    home = read_task_file(dog).plan.home
    assert home["FL_knee"] == pytest.approx(-1.8) and home["FL_hip"] == pytest.approx(0.9, abs=0.05)


def test_nothing_tells_the_reference(dog: Path) -> None:
    masked = get_task(str(dog)).masked_mjcf
    assert '<body name="FL_calf" pos="0 0 {-thigh_length}"' in masked
    legs = masked.partition('name="FL_thigh"')[2].partition('name="FR_thigh"')[0]
    assert not {"-0.2", "0.02", "0.015"} & set(legs.replace('"', " ").split())


def test_a_task_of_a_file_travels_as_bytes(dog: Path) -> None:
    task = get_task(str(dog))
    same = task_from_content(task_content(task))
    assert task_key(same) == task_key(task)
    assert task_content(get_task("ant")) == b"", "an installed task is known by its id"


def test_meshes_count_for_the_key(tmp_path: Path) -> None:
    source = write_arm(tmp_path)
    file = write_proposal(read_robot(source, "fixed"), source, tmp_path / "arm")
    before = fingerprint(read_task_file(file).task)
    mesh = file.with_name("shell.obj")
    mesh.write_text(mesh.read_text().replace("v 0 0 0.1", "v 0 0 0.11"))
    after = fingerprint(read_task_file(file).task)
    assert {"assets"} <= {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    ("part", "remedy"),
    [
        ('<include file="/etc/passwd"/>', "<include>, which reads other files"),
        ('<asset><mesh name="m" file="/etc/hosts"/></asset>', "reads the file '/etc/hosts'"),
        ('<asset><mesh name="m" file="x.stl" /></asset>', "which is not in it"),
        ('<include xmlns="q" file="/etc/passwd"/>', "names a namespace"),
        ('<q:include xmlns:q="q" file="/etc/passwd"/>', "names a namespace"),
    ],
)
def test_a_foreign_task_reads_no_file(dog: Path, part: str, remedy: str) -> None:
    content = task_content(get_task(str(dog))).decode()
    forged = content.replace("<worldbody>", part.replace('"', '\\"') + "<worldbody>")
    with pytest.raises(InputError, match=remedy):
        task_from_content(forged.encode())


@pytest.mark.parametrize(
    "name", ["/etc/passwd", "/tmp/x.stl", "../x.stl", "a\\\\x.stl", "x.xml", "policy.npz", ""]
)
def test_a_foreign_task_carries_nothing_but_meshes(dog: Path, name: str) -> None:
    content = json.loads(task_content(get_task(str(dog))))
    content["assets"] = {name.replace("\\\\", "\\"): "eA=="}
    with pytest.raises(InputError, match="is no name of a mesh"):
        task_from_content(json.dumps(content).encode())


@pytest.mark.parametrize("text", ["a\nb", "a\x1b[2J", "\u202ea", "a\tb", "x" * 1_000_000, "\0"])
@pytest.mark.parametrize("field", ["title", "unit", "mass", "description", "meaning"])
def test_a_foreign_tasks_texts_fit_where_they_are_shown(dog: Path, field: str, text: str) -> None:
    content = json.loads(task_content(get_task(str(dog))))
    if field == "meaning":
        content["parameters"][0]["meaning"] = text
    else:
        content[field] = text
    if field == "description" and text in ("a\nb", "a\tb"):
        assert task_from_content(json.dumps(content).encode()).description == text
        return
    with pytest.raises(InputError, match=f"{field}.*(characters|is long)") as refused:
        task_from_content(json.dumps(content).encode())
    assert len(str(refused.value)) < 500 and str(refused.value).isprintable()


def test_ones_own_texts_are_looked_at_when_the_file_is_read(dog: Path) -> None:
    title = next(line for line in dog.read_text().splitlines() if line.startswith("title"))
    with pytest.raises(InputError, match="its title is 'two"):
        read_task_file(edited(dog, title, 'title = "two\\nlines"'))


def test_a_fitness_of_ones_own_runs_for_its_author_alone(dog: Path) -> None:
    source = "def fitness(trajectory):\n    return 2.0 * trajectory.distance\n"
    text = f"fitness = {{ function = '''{source}''', unit = \"m\", meaning = \"twice as far\" }}"
    task = read_task_file(edited(dog, 'fitness = "distance"', text)).task
    assert (task.goal.name, task.goal.unit, task.goal.meaning) == ("own", "m", "twice as far")
    content = task_content(task)

    class Far:
        distance = 3.0

    mine, foreign = (task_from_content(content, trusted=trusted).goal for trusted in (True, False))
    assert mine(Far()) == 6.0  # type: ignore[arg-type]
    with pytest.raises(Exception, match="not executed"):
        foreign(Far())  # type: ignore[arg-type]
    kept = task_from_content(content, trusted=False)
    assert fingerprint(kept) == fingerprint(task), "it counts as the same task"
    with pytest.raises(Exception, match="not executed"):
        task_from_content(task_content(kept)).goal(Far())  # type: ignore[arg-type]


MISTAKES = {
    "a title without end": (
        'title = "',
        'title = "' + "x" * 201,
        "its title is .*; give one line of at most 200 characters",
    ),
    "a text without end": (
        'meaning = "',
        'meaning = "' + "x" * 1_001,
        "its meaning of 'thigh_length' is .*; give one line of at most 1,000",
    ),
    "an unknown measure": ('"distance"', '"energetic"', "no .* is called 'energetic'"),
    "an unknown line": (
        "control_hz",
        "kontrol_hz",
        "`kontrol_hz` is no line of it; did you mean control",
    ),
    "a line of another table": (
        "low = 0.1\n",
        "lowest = 0.1\n",
        "(thigh_length).*`lowest` is no line",
    ),
    "no id": ('id = "dog"', "", "the line `id = …` is missing"),
    "a number in quotes": (
        "high = 0.4\n",
        'high = "0.4"\n',
        r"\(thigh_length\), high: '0.4' is not a number",
    ),
    "an unknown change": (
        '"length"\nof',
        '"color"\nof',
        "changes: 'color' is none of 'length', 'radius'",
    ),
    "an unknown link": ('"FL_thigh"', '"FL_tigh"', "nothing is called 'FL_tigh'; there are FL_thi"),
    "bounds without the robot": (
        "low = 0.1\n",
        "low = 0.3\n",
        "the robot has 0.2, which is outside",
    ),
    "bounds the wrong way": ("high = 0.4", "high = 0.04", "low has to be above 0 and below high"),
    "no TOML": ("id = ", "id : ", "is no TOML"),
    "another mass mode": ('mass = "length"', 'mass = "air"', "mass: 'air' is none of 'density'"),
    "an installed id": ('id = "dog"', 'id = "ant"', "the id of another one; rename it"),
    "an unknown sensor": ("control_hz", 'sensors = ["gyr"]\ncontrol_hz', "there are gyro"),
    "no robot": ('"robot.xml"', '"robt.xml"', r"there is no file .*robt\.xml"),
    "a joint that is none": ("FL_knee =", "FL_nee =", "nothing is called 'FL_nee'"),
    "a joint beyond its range": ("FL_knee =", "FL_knee = 9.0 #", "FL_knee = 9, which is outside"),
    "no part": ("of = [", "of = [] #", "`of` is empty"),
    "a word of Python's": ('name = "thigh_length"', 'name = "lambda"', "no word of Python's"),
    "a tilt below 0": ("tilt_degrees = ", "tilt_degrees = -", "tilt_degrees = -.*above 0"),
    "no turn": (
        "[home.joints]",
        "[home]\nupright = [0, 0, 0, 0]\n[home.joints]",
        "upright = .* not 0",
    ),
    "brackets": ('mass = "length"', "mass = " + 100_000 * "[", "nested too deeply"),
    "an endless torque": (
        "[[parameter]]\n",
        '[[actuator]]\njoints = ["FL_hip"]\nkind = "motor"\ntorque = 1e12\n[[parameter]]\n',
        r"torque = 1e\+12; give a number",
    ),
    "bounds without an end": ("high = 0.4", "high = inf", r"high = inf.*1e\+06 at most"),
    "a number of many digits": ("control_hz = ", "control_hz = " + "9" * 10_000, "is no TOML"),
    "a key of many tables": ('mass = "length"', "a" + ".a" * 100 + " = 1", "a key with 30 dots"),
    "a long file": ('mass = "length"', "#" * 2**20, "has more than 1 MiB"),
    "a long id": ('id = "dog"', f'id = "{"d" * 80}"', "give one of letters.*64 at most"),
    "a misspelt fitness": (
        'fitness = "distance"',
        'fitness = "distnce"',
        r"fitness: .*'distnce'.*'distance'",
    ),
    "many terms": (
        'fitness = "distance"',
        "fitness = [" + '{measure = "distance"},' * 101 + "]",
        "fitness has 101 terms; give 100 at most",
    ),
    "degrees for radians": (
        '"distance"',
        '{ measure = "time-upright", options = { tilt = 45.0 } }',
        "'time-upright' has tilt = 45.0; give a number from 0.001 to 3.14 rad",
    ),
    "a measure and a function": (
        '"distance"',
        '{ measure = "distance", function = "def fitness(t): return 1" }',
        "'distance' stands beside the text of a function",
    ),
    "a part that is none": (
        '"distance"',
        '{ measure = "target-reached", options = { target = [1, 0], part = "FL_fot" } }',
        "'target-reached': the robot has no part 'FL_fot'. Did you mean 'FL_foot'",
    ),
    "a target that is reached at rest": (
        '"distance"',
        '{ measure = "target-reached", options = { target = [1, 0], radius = 5.0 } }',
        "radius = 5 m, and the robot rests 1 m from its target",
    ),
    "a target nowhere": (
        "[[parameter]]\n",
        '[target]\npart = "FL_calf"\nposition = [0, nan, 0]\n[[parameter]]\n',
        r"position = \[0.0, nan, 0.0\]; give x, y, z from -1000 to 1000 m",
    ),
}


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    for name in ("task.toml", "robot.xml"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=r"task\.toml is a named pipe"):
        get_task(str(tmp_path / "task.toml"))
    with pytest.raises(InputError, match=r"robot\.xml is a named pipe"):
        read_robot(tmp_path / "robot.xml")


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named(dog: Path, mistake: str) -> None:
    old, new, said = MISTAKES[mistake]
    with pytest.raises(InputError, match=said):
        get_task(str(edited(dog, old, new)))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("return float('nan')", "gave nan, no finite number"),
        ("return trajectory.way", "raised AttributeError"),
        ("return 'far'", "raised ValueError"),
        ("return (", "does not|syntax|never closed"),
    ],
)
def test_a_fitness_that_cannot_work_is_found_before_training(
    dog: Path, body: str, said: str
) -> None:
    source = f"def fitness(trajectory):\n    {body}\n"
    text = f"fitness = {{ function = '''{source}''', unit = \"m\", meaning = \"how far\" }}"
    with pytest.raises((AssertionError, InputError), match=said):
        check_task(read_task_file(edited(dog, 'fitness = "distance"', text)).task)


@pytest.mark.parametrize("least", ["1.5", "1.0"])
def test_episodes_that_end_at_once_are_found_before_training(dog: Path, least: str) -> None:
    """Also those that begin healthy: from exactly its rest height a robot can only sink."""
    task = read_task_file(edited(dog, "height = [0.5,", f"height = [{least},")).task
    with pytest.raises(AssertionError, match="each ends at once"):
        check_task(task)


def test_a_robot_without_motors_is_given_some_and_refused_without(tmp_path: Path) -> None:
    bare = DOG.partition("<actuator>")[0] + "</mujoco>"
    source = write_dog(tmp_path, bare)
    file = write_proposal(read_robot(source), source, tmp_path / "bare")
    task = read_task_file(file).task
    model = mujoco.MjSpec.from_string(task.mjcf(task.reference)).compile()
    assert model.nu == 8 and (model.actuator_forcerange[:, 1] > 3).all()
    text = file.read_text()
    first, last = text.index("[[actuator]]"), text.index("[[parameter]]")
    file.write_text(text[:first] + text[last:])
    with pytest.raises(InputError, match="no motors, so nothing can be learned"):
        read_task_file(file)


def test_free_parts_are_chosen_by_pattern(tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    robot = read_robot(source)
    free = ("calf", "knee_strength")
    task = read_task_file(write_proposal(robot, source, tmp_path / "a", free)).task
    assert task.names == ("calf_length", "calf_radius", "knee_strength")
    assert task.parameters[2].unit == "N·m" and task.reference[2] == 20
    with pytest.raises(InputError, match=r"--free wing: nothing fits; there are .*thigh_length"):
        write_proposal(robot, source, tmp_path / "b", ("wing",))


def test_designers_are_told_the_names(dog: Path) -> None:
    told = environment_source(get_task(str(dog)))
    for name in ("FL_knee", "FL_foot", "gyro", "def joint(", "def contact_force(", "_get_rew"):
        assert name in told
    assert "qpos[self._first_qpos" not in told


def test_a_range_without_width_is_named_once(tmp_path: Path) -> None:
    source = write_dog(tmp_path)
    file = write_proposal(read_robot(source), source, tmp_path / "dog")
    text = re.sub(
        r"^low = .*\nhigh = .*", "low = 0.3\nhigh = 0.3", file.read_text(), count=1, flags=re.M
    )
    file.write_text(text)
    with pytest.raises(InputError, match=r"0\.3") as refused:
        read_task_file(file)
    assert "which is outside" not in str(refused.value)
