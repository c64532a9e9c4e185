"""How the cases of a run are spread and kept: shards, local workers, a Dask cluster, and the journal of a run.

Rules: CNF-20.
"""
