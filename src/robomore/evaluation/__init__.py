"""From designs to numbers: check, compile, train, roll out, divide fitness by volume.

`evaluate.evaluate` does one job, the same code here, in a worker process or on a cluster.
`evaluator.Evaluator` does batches: it looks up what the ledger knows, has the rest done, and writes
down each as it finishes. `train.train` is the only part that runs untrusted code.
"""
