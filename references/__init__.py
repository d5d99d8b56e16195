"""What tests and benchmarks measure against: scenes, and converged pictures of them."""
