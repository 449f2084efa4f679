"""Comparisons of semiwear with what is known otherwise; `python -m validation` writes them as a report."""
