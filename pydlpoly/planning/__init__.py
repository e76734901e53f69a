"""A model of large runs: time, memory and what goes into exchanging halos, against the number of ranks."""
