"""Frozen results: what the code computed when they were stored, to nine digits.

`scenes` names the runs, `digest` makes a few numbers of each variable, `stored` keeps them in `data/`, one file a
run. A change that moves a number on purpose renews the runs that it moves: `python -m tests.baseline NAME ...`
"""
