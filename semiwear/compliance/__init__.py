"""Compliance besides the local contact: teeth and rims of both bodies."""
