"""The side of the decoder: what runs between the runner and a foreign program.

Rules: CNF-14. `warden` is started as a script of its own, by `snhc.conformance.process`.
"""
