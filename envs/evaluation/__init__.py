"""Policies and forecasters compared: episodes, metrics, statistics, and tests under stress.

`evaluate` runs every arm of a `comparison` on common seeds and `stress` turns one knob at a time;
`metrics` measures an episode, `summary` and `statistics` make means, intervals and paired
differences of many, and `findings` says in words what they amount to.
"""
