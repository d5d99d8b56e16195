"""Pictures in passes: room for rays, lists of samples, antialiasing, derivatives, and what is left out."""
