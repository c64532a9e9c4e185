"""The adaptive arithmetic coder (FBA-21..27) and prefix codes."""
