"""Benchmarks: named scenes built in memory, timed in processes of their own that take turns.

``scenes`` says what is run, ``worker`` and ``lammps_worker`` are the programs that run and time it, ``processes`` talks
to them, ``measure`` decides who runs when, ``results`` holds and prints what was found, ``cli`` is ``pydlpoly bench``.
"""
