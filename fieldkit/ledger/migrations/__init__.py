"""Alembic's folder: `env.py` connects it to an open ledger, `versions/` has one file per step."""
