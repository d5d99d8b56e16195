"""What a fit looks for and looks at: unknowns, their bounds, targets, and residuals with their Jacobian."""
