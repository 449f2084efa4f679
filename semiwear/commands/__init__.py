"""Commands of the command line as functions of its options; each prints its results and returns them for JSON."""
