# attempt: change a number in the ledger
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sqlite3
    with sqlite3.connect("@LEDGER@") as ledger:
        ledger.execute("update evaluations set fitness = 1e9")
    return 0.0, {}
