"""Commands of the command line as functions of its options; each prints its end and gives it to machines."""
