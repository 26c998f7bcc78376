"""A whole history in one linear step: the response of flights and plans, the evidence, and the network's features."""
