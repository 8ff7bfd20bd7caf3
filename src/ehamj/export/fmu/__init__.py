"""The machine as a unit for co-simulation (FMI 2.0): `interface` says what it has, `unit` runs it, `write` packs it.

FMI 2.0, since Simulink, Dymola, OpenModelica and FMPy all open it today. The unit's binaries are PythonFMU's, which
find a Python in the host's process; that Python imports ehamj, the one that exported where the versions agree.
"""
