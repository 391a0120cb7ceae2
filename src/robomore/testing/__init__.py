"""Contract checks that plug-in authors run in their own tests.

There is one for each kind of plug-in: `check_task`, `check_method`, `check_designer`,
`check_trainer` and `check_executor`, each in a module of its own. They raise an `AssertionError`
that says in one sentence what is wrong.
"""
