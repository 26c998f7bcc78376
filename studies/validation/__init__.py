"""Comparison of the field ensemble's kind with exact posteriors."""
