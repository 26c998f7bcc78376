"""Studies of the methods: the reference paper put to the test."""
