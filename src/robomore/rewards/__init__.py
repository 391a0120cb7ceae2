"""Rewards: what is wrong with the text of a reward, before anything is trained under it.

A reward is program text that may come from anybody. `check` reads it and says what is wrong, `load`
turns it into a function (only inside a sandboxed process), and `dry_run` tries it for a moment on
moving robots before a training is spent on it.
"""
