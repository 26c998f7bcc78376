"""The loop: predict, compare, find what the model lacks, add it, predict again."""
