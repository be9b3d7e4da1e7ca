"""The second comparison: volumes of touching labels, of which few slices are kept."""
