"""How a fit is told: tables, reports, plots and files."""
