"""The coverage book: which cells of the syntax and of the decoder the vectors reach, and why the others stay empty."""
