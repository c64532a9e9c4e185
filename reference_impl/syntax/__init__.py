"""One syntax, many machines: elements, the `SyntaxIO` base, reader, writer, tracer, faulty writer."""
