"""From a body and a reward to a policy, in one thread and the same to the last bit each time.

A `Trainer` (`trainer`) takes simulations stepped together and a budget, and returns an `MLPPolicy`
(`policy`), plain arrays that act with NumPy alone. `settings` knows the algorithms by name; `loop`
is what they share, `crossq` is the default. `rollout` runs a policy for what it is worth.
"""
