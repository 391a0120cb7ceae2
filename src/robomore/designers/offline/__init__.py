"""The designer that needs no language model, no key and no network.

Morphologies come from a plausibility prior and a Gaussian process, rewards from a library of
standard terms. Only this designer uses what lies here.
"""
