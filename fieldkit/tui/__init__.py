"""The app for the launch site: one file per page in `screens/`, each over the functions that the commands call."""
