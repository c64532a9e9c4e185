"""Right in everything."""

from _shared import answer, finish

finish(*answer())
