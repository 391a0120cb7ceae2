"""Contract checks that plug-in authors run in their own tests."""
