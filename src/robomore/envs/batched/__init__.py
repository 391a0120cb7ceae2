"""Rewards run for many simulations at once, where that gives the numbers of one at a time.

A designer writes a reward for one robot: `self.data.qvel[1]`, an `if`, something kept in `self`.
Here it meets a `self` whose numbers are those of all simulations (`robot`, `value`), NumPy's
functions for such numbers (`arrays`), and conditions that part the simulations into groups
(`group`). Its first runs, and every new way through it, are compared with runs per simulation
(`check`, `trust`); whatever disagrees or cannot be done for many runs per simulation from then on
(`reward`).
"""
