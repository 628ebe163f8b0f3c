"""Gives a wheel that carries compiled kernels (flexmb/compiled) the tag of its Python and platform."""

from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompiledKernels(BuildHookInterface):
    def initialize(self, version, build_data):
        if any((Path(self.root) / "flexmb" / "compiled").glob("*/*")):
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
