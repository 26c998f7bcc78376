"""Whether a trained network would improve the quick answers: simulated histories, training, and the ablation."""
