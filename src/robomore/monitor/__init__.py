"""Monitor: from the events of a run to its state now, for whoever shows it.

The terminal and the page both read what is gathered here, so they cannot disagree about progress,
the best so far or the time left.
"""
