"""Arithmetic that knows what XLA does on a CPU: vectors, safe primitives, coverage of pixels, stages, threads."""
