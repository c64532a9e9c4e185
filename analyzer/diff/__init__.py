"""What differs between two streams: element by element, and value by value."""
