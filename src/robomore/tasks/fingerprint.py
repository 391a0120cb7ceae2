"""TEMP"""

from robomore.identity import content_key


def fingerprint(task):
    return {"template": content_key(task.template)[:16], "reward": content_key(task.reward)[:16]}


def task_key(task):
    return content_key(fingerprint(task))
