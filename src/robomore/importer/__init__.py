"""A robot of one's own: from an MJCF or URDF file to a `Task`.

`reading` opens the file with MuJoCo's `MjSpec` and keeps what is simulated. `limbs` finds the links
that form limbs, and those that repeat. `proposal` proposes free parameters and writes a task file,
which a person edits. `task_file` reads a task file, and `template` turns the robot and its free
parameters into an MJCF template. The `Task` that results needs no file: meshes travel inside it.
"""
