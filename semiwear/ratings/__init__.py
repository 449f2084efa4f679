"""Failure modes of gear teeth, rated from the loaded, worn contact."""
