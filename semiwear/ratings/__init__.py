"""Failure modes of the worn flanks: safeties from local pressure, root stress, film and temperature.

A mode is a table of a scene (`semiwear.scene.rating_tables`), a file here, and an entry in `semiwear.plan.ratings`.
"""
