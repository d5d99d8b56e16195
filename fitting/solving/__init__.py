"""How a fit gets there: Levenberg-Marquardt, stages from coarse to fine, and a look along the rays that move."""
