"""The app for the launch site: a page a file in `screens/`, each over the functions that the commands call."""
