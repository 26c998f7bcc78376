"""The app for the launch site: one file per page in `screens/`, using the same functions as the commands."""
