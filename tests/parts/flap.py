"""How model files of tests begin that describe a flexible body by its pieces; fields of its `data` follow."""

FLAP = """[[body]]
kind = "Ground"
[[body]]
kind = "FloatingBody"
name = "flap"
[body.data]
"""
