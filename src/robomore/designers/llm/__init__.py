"""The designer of the paper: a language model that proposes, corrects and improves.

This package makes the prompts, selects the history that they hold, and parses the replies. The
package `robomore.llm` reaches the model (providers, retries, budgets, recording) and knows nothing
of robots.
"""
