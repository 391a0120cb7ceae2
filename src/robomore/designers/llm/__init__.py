"""The designer of the paper: a language model that proposes, is corrected, and improves.

Here belong the prompts, the history that a prompt holds, and reading proposals out of replies. How
a model is reached (providers, retries, budgets, recording) belongs in `robomore.llm`, which knows
nothing of robots.
"""
