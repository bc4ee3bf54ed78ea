"""A public test for tools that say what a model of an antenna lacks. Nothing of the product is imported here."""
