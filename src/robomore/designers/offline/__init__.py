"""The designer that needs no language model, no key and no network.

It samples morphologies from a plausibility prior and improves them with a Gaussian process. It
composes rewards from a library of standard terms.
"""
