"""Run by Alembic when a ledger is upgraded, inside the transaction that `opening.bring_up_to_date` started."""

from alembic import context

context.configure(connection=context.config.attributes["connection"], transactional_ddl=True)
context.run_migrations()
