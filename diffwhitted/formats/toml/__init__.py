"""Scenes as TOML: what a file may say, what is wrong with one, reading and writing."""
