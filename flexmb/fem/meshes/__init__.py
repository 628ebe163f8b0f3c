"""Meshes and the files that hold them: cells, groups, facets, one reader per format."""
