"""What accuracy costs: settings of pictures and of fits side by side."""
