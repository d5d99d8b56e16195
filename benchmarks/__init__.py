"""Speed and memory, each beside the error that comes with it."""
