"""Three-dimensional finite-element cross-check of the fast core (scikit-fem).

It will hold a multi-tooth contact model that computes pressure, load sharing, root stress, transmission
error and wear independently of the core. It may import `semiwear.scene`, `semiwear.geometry` and
`semiwear.results`; the core never imports it.
"""
