"""Runs untrusted code, such as a reward, in a process that can do no harm.

`call.run_sandboxed` calls a function in a process of its own. That process can reach no file but
its scratch folder, no network, no other process and no key. `layers` tries out which of these
protections this machine offers. `linux` wraps the mechanisms of the kernel behind them.
"""
