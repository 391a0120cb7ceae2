"""Environments: everything that simulates.

Here belongs whatever needs MuJoCo or Gymnasium: compiling a task's MJCF into a model, the robots as
Gymnasium classes, the vector environment that policies are trained and measured in, the mesh of a
terrain, and the registration with `gymnasium.make`. What a task *is* (numbers and texts) belongs in
`robomore.tasks`; what draws a robot belongs in `robomore.rendering`.
"""
