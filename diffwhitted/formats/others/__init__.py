"""What the readers of other programs' scenes share: shapes under a transform, patterns, and what was found."""
