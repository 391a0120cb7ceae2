"""From a design to a policy, in one thread, and the same to the last bit each time.

A `Trainer` (`trainer`) takes a `TrainingEnv` and a budget of control steps. It returns the policies
(`policy`: plain arrays that act with NumPy alone) and the learning curve (`curve`). `settings`
knows the algorithms by name, and `tuned` what each robot needs. `crossq` is the default, `sac` and
`sb3` are the paper's algorithm; `loop` and `actor_critic` are what our own two share. `rollout`
runs a
policy to measure it.
"""
