"""Which effects a model lacks: candidates, their evidence, and the flight that distinguishes them."""
