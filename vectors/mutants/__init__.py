"""The kill matrix: mistakes of implementers, as patches of the reference decoder, and the vectors that show them.

Rules: CNF-8. `mutant`: what a mutant is; `patching`: how it is put in and taken out; `matrix`: the result; `text`,
`page`: how it is shown; the other modules: the mutants by topic. The engine that runs them is
`conformance/kill_matrix.py`: what kills a mutant is what fails a decoder.
"""
