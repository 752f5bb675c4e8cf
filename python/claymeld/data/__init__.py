"""Values and files: what meldsim reads and writes, as Python has it. Of this package it imports only `tool`, and never what users call."""
