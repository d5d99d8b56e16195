"""What an end of a fit is worth: rest, misfit, what the pictures determine, and the outcome in words."""
