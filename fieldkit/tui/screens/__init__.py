"""The pages of the app; a module that binds `PAGE` is one, in the order of their numbers."""
