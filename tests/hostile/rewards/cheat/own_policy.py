# attempt: leave a policy of its own and end the training
# expect: crashed
# check: error

def _get_rew(self, x_velocity, action):
    import json, os
    with open("policy.json", "w") as file:
        json.dump({"force": 1e9, "fitness": 1e9}, file)
    os._exit(0)
