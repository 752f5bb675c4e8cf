"""Calling the tool: finding meldsim, its processes, and its errors as exceptions. It imports nothing else of this package."""
