"""A whole history in one linear step: what flights and plans would show, evidence, and the features of the network."""
