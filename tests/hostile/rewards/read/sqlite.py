# attempt: open another database
# expect: reward-failed
# check: error

def _get_rew(self, x_velocity, action):
    import sqlite3
    loot = list(sqlite3.connect("@LEDGER@").execute("select * from evaluations"))
    raise RuntimeError(f"loot: {loot!r}")
