"""What flexmb uses of numba beyond its documented face, each thing by name: a new numba is tried here first."""

import inspect
import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import numba
import numpy as np
from numba import njit, types
from numba.core import cgutils, config, event, ir
from numba.core.analysis import compute_cfg_from_blocks
from numba.core.caching import NullCache, _Cache
from numba.core.ccallback import CFunc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder, Flags, run_frontend
from numba.core.funcdesc import FunctionDescriptor
from numba.core.lowering import Lower
from numba.core.pythonapi import PythonAPI
from numba.core.registry import cpu_target
from numba.core.runtime import rtsys
from numba.core.serialize import dumps
from numba.core.targetconfig import TargetConfig
from numba.core.typed_passes import BaseNativeLowering, NativeLowering, NopythonTypeInference
from numba.core.typing import Signature
from numba.core.typing.templates import make_intrinsic_template
from numba.extending import intrinsic
from numba.np.arrayobj import fancy_setslice, populate_array

from flexmb.math.unequal_sizes import with_sizes


def parameters(function):
    return tuple(inspect.signature(function).parameters)


def test_installed_version_is_within_the_bounds():
    """An upper bound stands in the requirements, and the numba that runs is below it."""
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())["project"]
    (wanted,) = (text for text in project["dependencies"] if re.match(r"numba\b", text))
    low, high = re.search(r">=([\d.]+)", wanted)[1], re.search(r"<([\d.]+)", wanted)[1]
    number = lambda text: tuple(int(part) for part in re.findall(r"\d+", text)[:2])  # noqa: E731
    assert number(low) <= number(version("numba")) < number(high)


def test_a_cache_is_asked_and_told():
    """`Dispatcher._cache` and `CFunc._cache` are objects with these methods and no others."""
    assert _Cache.__abstractmethods__ == {"cache_path", "load_overload", "save_overload", "enable", "disable", "flush"}
    assert parameters(_Cache.load_overload) == ("self", "sig", "target_context")
    assert parameters(_Cache.save_overload) == ("self", "sig", "data")
    assert isinstance(njit(lambda x: x)._cache, NullCache)
    code = CFunc(lambda x: x, ((types.float64,), types.float64), locals={}, options={"error_model": "numpy"})
    assert isinstance(code._cache, NullCache)
    for compiled in (numba.core.dispatcher.Dispatcher.compile, CFunc.compile):
        text = inspect.getsource(inspect.unwrap(compiled))
        assert "self._cache.load_overload(" in text
        assert "self._cache.save_overload(" in text


def test_compiling_makes_types_and_operators_ready_itself():
    """So `KernelCache` need not where it only loads: half of the time of a first simulation went there."""
    text = inspect.getsource(CompilerBase.__init__)
    assert "typingctx.refresh()" in text
    assert "targetctx.refresh()" in text
    assert parameters(type(rtsys).initialize) == ("self", "ctx")


def test_a_compiled_function_has_these_parts():
    """`KernelLibrary` and `rebuilt` put a `CompileResult` together from them."""
    half = njit(lambda x: 0.5 * x)
    assert half(3.0) == 1.5
    (result,) = half.overloads.values()
    assert set(result._fields) == {
        *("typing_context", "target_context", "entry_point", "typing_error", "type_annotation", "signature"),
        *("objectmode", "lifted", "fndesc", "library", "call_helper", "environment", "metadata"),
        *("reload_init", "referenced_envs"),
    }
    assert (result.library.has_dynamic_globals, tuple(result.lifted)) == (False, ())
    assert all(environment.can_cache() for environment in result._find_referenced_environments())
    assert isinstance(dumps((result.fndesc.uid, result.fndesc.argtypes, result.fndesc.llvm_func_name)), bytes)


def test_a_library_of_ours_takes_the_place_of_numbas():
    """What `KernelLibrary` and `KernelCompiler` override or call."""
    lowering = inspect.getsource(BaseNativeLowering.run_pass)
    assert "if state.library is None:" in lowering
    assert "enable_object_caching()" in lowering
    assert parameters(JITCodeLibrary.__init__) == ("self", "codegen", "name")
    assert parameters(JITCodeLibrary.add_linking_library) == ("self", "library")
    for name in ("_ensure_finalized", "_finalize_final_module", "_get_compiled_object", "_set_compiled_object"):
        assert callable(getattr(JITCodeLibrary, name))
    assert "self._shared_module is not None" in inspect.getsource(JITCodeLibrary._get_module_for_linking)
    assert parameters(CompilerBase.compile_extra) == ("self", "func")
    assert parameters(CompilerBase._compile_bytecode) == ("self",)
    assert isinstance(cpu_target.target_context.codegen()._engine._defined_symbols, set)
    symbol = inspect.getsource(FunctionDescriptor.__init__)
    assert "abi_tags=abi_tags, uid=uid" in symbol
    assert "uid=func_ir.func_id.unique_id" in inspect.getsource(FunctionDescriptor._from_python_function)


def test_what_the_code_was_made_for_is_known():
    """Triple, processor and its features; the settings that change code."""
    triple, processor, features = cpu_target.target_context.codegen().magic_tuple()
    assert all(isinstance(text, str) for text in (triple, processor, features))
    assert {"CACHE_DIR", "OPT", "BOUNDSCHECK"} <= vars(config).keys()


def test_parts_of_functions_and_types_have_these_names():
    function = njit(lambda x: x)
    assert {"py_func", "targetoptions"} <= set(dir(function))

    @intrinsic
    def nothing(context):
        return types.void(), None

    assert nothing._defn.__name__ == "nothing"
    record = Signature(types.float64, (types.int64,), None)
    assert (record.return_type, record.args) == (types.float64, (types.int64,))
    array = types.Array(types.float64, 1, "C")
    assert (array.dtype, array.ndim, array.layout, array.mutable, array.aligned) == (types.float64, 1, "C", True, True)
    assert tuple(types.Tuple((types.float64, types.int64))) == (types.float64, types.int64)
    assert types.Dispatcher(function).dispatcher is function


def test_compiling_is_announced():
    said = []

    class Listener(event.Listener):
        def on_start(self, event):
            said.append("begins")

        def on_end(self, event):
            said.append("ends")

    with event.install_listener("numba:compile", Listener()):
        njit(lambda x: x)(1.0)
    assert said == ["begins", "ends"]


def test_kernels_have_passes_of_their_own():
    """`KernelCompiler` puts two passes in the places of numba's, with names that lowering and typing ask for."""
    state = CompilerBase(cpu_target.typing_context, cpu_target.target_context, None, (), None, Flags(), {}).state
    kinds = [kind for kind, _ in DefaultPassBuilder.define_nopython_pipeline(state).passes]
    assert kinds.count(NativeLowering) == kinds.count(NopythonTypeInference) == 1
    assert isinstance(NativeLowering.lowering_class, property)
    for name in ("pre_lower", "lower_expr", "lower_inst", "lower_getitem", "lower_setitem", "fold_call_args"):
        assert callable(getattr(Lower, name))
    assert "resolve_value_type(op)" in inspect.getsource(Lower.lower_getitem)
    assert "state.typingctx" in inspect.getsource(NopythonTypeInference.run_pass)
    assert set(Flags().__slots__) <= {"_values"}
    assert "_values" in TargetConfig.__slots__


def test_a_failed_compilation_is_told():
    """`kernel_claims` reads the details: `Event.is_failed` of numba 0.68 says the contrary of its name."""
    assert event.Event("numba:compile", event.EventStatus.END)._exc_details is None
    assert event.Event("numba:compile", event.EventStatus.END, exc_details=(ValueError, 1, 2))._exc_details


def test_calls_on_demand_are_made_of_these():
    """`kernel_on_demand` types and writes calls of its own."""
    assert parameters(make_intrinsic_template)[:3] == ("handle", "defn", "name")
    convention = cpu_target.target_context.call_conv
    assert parameters(convention.get_function_type) == ("restype", "argtypes")
    assert parameters(convention.call_function)[:5] == ("builder", "callee", "resty", "argtys", "args")
    assert parameters(convention.return_user_exc)[:3] == ("builder", "exc", "exc_args")
    assert parameters(convention.return_status_propagate) == ("builder", "status")
    assert callable(JITCodeLibrary.get_pointer_to_function)


def test_arrays_are_read_without_references():
    """`structure_type` fills blocks by this function of numba's library; a block of an array is its data model."""
    assert "numba_adapt_ndarray" in inspect.getsource(PythonAPI.numba_array_adaptor)
    array = types.Array(types.float64, 2, "C")
    context = cpu_target.target_context
    assert context.get_abi_sizeof(context.get_data_type(array)) == 8 * (5 + 2 * 2)


def test_arrays_of_constant_size_are_found_and_made():
    """`own_room` reads calls of numpy's functions, loops, and what keeps a function's values when it has ended."""

    def function(x):
        a = np.zeros(3)
        for k in range(3):
            a[k] = x
        return a[0]

    state = run_frontend(function)
    graph = compute_cfg_from_blocks(state.blocks)
    (loop,) = graph.loops().values()
    assert set(loop.body) < set(state.blocks)
    assert state.is_generator is False
    assert cpu_target.typing_context.resolve_value_type(np.zeros).typing_key is np.zeros
    assert {"size", "name", "zfill"} < set(parameters(cgutils.alloca_once))
    assert parameters(populate_array) == ("array", "data", "shape", "strides", "itemsize", "meminfo", "parent")
    assert "if meminfo is None" in inspect.getsource(populate_array)
    manager = cpu_target.target_context.data_model_manager
    assert manager[types.Array(types.float64, 1, "C")].contains_nrt_meminfo()
    assert not manager[types.float64].contains_nrt_meminfo()
    for raised in (ir.DynamicRaise, ir.DynamicTryRaise):
        assert issubclass(raised, ir.Stmt)


def test_the_error_for_other_sizes_is_asked_for_by_name():
    """The typing context of kernels gives one with a constant text (`flexmb/math/unequal_sizes.py`)."""
    text = inspect.getsource(fancy_setslice)
    if with_sizes is None:
        assert "raise_with_shape_context" not in text
    else:
        assert parameters(with_sizes) == ("src_shapes", "index_shape")
        assert re.search(r"typing_context\.resolve_value_type\(\s*raise_with_shape_context\)", text)
