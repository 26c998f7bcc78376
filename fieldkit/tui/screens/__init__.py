"""The pages of the app: every module that binds `PAGE`, in the order of their numbers."""
