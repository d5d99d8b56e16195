"""The families of surfaces, one a file."""
