"""Alembic's folder: `env.py` connects it to an open ledger, `versions/` holds a file per step."""
