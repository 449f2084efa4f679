"""Wear of a mesh, and the steps from one worn flank to the next."""
