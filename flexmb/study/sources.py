"""What a study varies: a model file with parameters, or a Python function of them."""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import pickle
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import flexmb as fmb
from flexmb.errors import FlexmbError, ModelError, did_you_mean
from flexmb.files import resolved
from flexmb.io import OpenModelFile
from flexmb.model import Model
from flexmb.results import Solution
from flexmb.study.outputs import columns

__all__ = ["FunctionSource", "ModelFile", "function_in", "require_end"]

MODEL, SOLUTION, TABLE = "model.toml", "solution.h5", "sensors.csv"
"""The files of a run folder, as `flexmb run` writes them."""


@dataclass(frozen=True)
class ModelFile:
    """A model file whose ``[parameters]`` are varied.

    Parameters
    ----------
    path : str
    parameters : mapping
        Values that replace the file's in all variants.
    t_end : float, s, optional
    samples : int, optional
    time_limit : float, s, optional
        Replace the values of ``[simulation]``.
    """

    path: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    t_end: float | None = None
    samples: int | None = None
    time_limit: float | None = None
    trust: bool = False

    def __post_init__(self):
        object.__setattr__(self, "path", str(resolved(self.path)))

    def check(self, names: Sequence[str], outputs: Sequence[str] | None, first: Mapping[str, Any]) -> None:
        """Raise FlexmbError unless the file can be read, and has the parameters and the sensors.

        The model of the `first` variant is looked at: the parts of finite elements that it needs are wanted anyway.
        """
        model = self._example(first)
        self._simulation({})
        part = f"{Path(self.path).name}, [parameters]"
        for name in names:
            if name in self.parameters:
                raise ModelError(
                    part,
                    found=f"'{name}' is varied and set to {self.parameters[name]!r}",
                    expected="one or the other",
                    remedy=f"Leave out --set {name}",
                )
            _check_known(name, model.parameters, part, "The file has")
        columns(outputs, model)

    def identity(self, first: Mapping[str, Any]) -> dict[str, Any]:
        """Return what a stored study is compared with: content of the model of a variant, not its date."""
        model = self._example(first)
        digest = hashlib.sha256(fmb.model_text(model).encode())
        for body in model.bodies:
            data = getattr(body, "data", None)
            if data is not None:
                digest.update(data.frequencies.tobytes() + data.nodes.tobytes() + data.shapes.tobytes())
        simulation = {name: repr(value) for name, value in self._simulation({}).keywords().items()}
        simulation.pop("time_limit", None)  # a study goes on with more time
        return {"model": digest.hexdigest()[:20], **simulation}

    def values(self, parameters: Mapping[str, Any], outputs, folder: Path | None) -> dict[str, float]:
        """Return the numbers of one variant; with a folder, it becomes a run folder."""
        model, simulation = self._model(parameters), self._simulation(parameters)
        if folder is None:
            return _simulated(model, simulation.keywords(), outputs, folder)
        fmb.save_model(model, folder / MODEL, simulation, bodies_in=SOLUTION)
        try:
            return _simulated(model, simulation.keywords(), outputs, folder)
        finally:
            if not (folder / SOLUTION).is_file():  # nothing to hold the reduced bodies
                fmb.save_model(model, folder / MODEL, simulation)

    def opened(self) -> Callable[[Mapping[str, Any]], tuple[Model, dict[str, Any]]]:
        """Return a function of a variant's parameters: its model, and how it is simulated."""
        file = OpenModelFile(self.path, trust=self.trust)

        def described(parameters: Mapping[str, Any]) -> tuple[Model, dict[str, Any]]:
            given = {**self.parameters, **parameters}
            return file.model(given), file.simulation(given, **self._own()).keywords()

        return described

    def _example(self, first: Mapping[str, Any]) -> Model:
        """Return the model of a variant, or the file's own if the variant cannot be made."""
        try:
            return self._model(first)
        except FlexmbError:
            return self._model({})

    def _model(self, parameters: Mapping[str, Any]) -> Model:
        return fmb.load_model(self.path, {**self.parameters, **parameters}, trust=self.trust)

    def _simulation(self, parameters: Mapping[str, Any]):
        given = {**self.parameters, **parameters}
        return fmb.load_simulation(self.path, given, **self._own())

    def _own(self) -> dict[str, Any]:
        return {"t_end": self.t_end, "samples": self.samples, "time_limit": self.time_limit}


@dataclass(frozen=True)
class FunctionSource:
    """A function of the parameters that returns a Model, a Solution, a number, or a mapping of numbers.

    Parameters
    ----------
    function : callable
        Of a module that the workers can import: no lambda, and in a script below ``if __name__ == "__main__"`` only
        code that must not run again in every worker.
    parameters : mapping
        Arguments that stay the same.
    t_end : float, s, optional
    samples : int, optional
    time_limit : float, s, optional
        For functions that return a Model.
    """

    function: Callable[..., Any]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    t_end: float | None = None
    samples: int | None = None
    time_limit: float | None = None

    @property
    def title(self) -> str:
        return f"Function '{getattr(self.function, '__name__', self.function)}'"

    def check(self, names: Sequence[str], outputs: Sequence[str] | None, first: Mapping[str, Any]) -> None:
        """Raise ModelError unless the function takes the parameters and can be sent to a worker."""
        arguments = inspect.signature(self.function).parameters.values()
        takes = [a.name for a in arguments if a.kind in (a.POSITIONAL_OR_KEYWORD, a.KEYWORD_ONLY)]
        if not any(a.kind is a.VAR_KEYWORD for a in arguments):
            for name in (*names, *self.parameters):
                _check_known(name, takes, self.title, "It takes")
        missing = [a.name for a in arguments if a.default is a.empty and a.name in takes]
        missing = [name for name in missing if name not in names and name not in self.parameters]
        if missing:
            raise ModelError(
                self.title,
                found=f"its argument '{missing[0]}' has no value",
                expected="a value for every argument without a default",
                remedy=f"Vary {missing[0]}, or set it",
            )
        try:
            pickle.dumps(self.function)
        except (pickle.PicklingError, AttributeError, TypeError) as error:
            raise ModelError(
                self.title,
                found=f"it cannot be sent to another process ({error})",
                expected="a function defined at the top of a module",
                remedy="Give it a name with def, outside of other functions",
            ) from error

    def identity(self, first: Mapping[str, Any]) -> dict[str, Any]:
        """Return what a stored study is compared with: the text of the function."""
        try:
            text = inspect.getsource(self.function)
        except (OSError, TypeError):
            text = repr(self.title)
        digest = hashlib.sha256(text.encode()).hexdigest()[:20]
        return {"function": digest, "t_end": repr(self.t_end), "samples": repr(self.samples)}

    def opened(self) -> Callable[[Mapping[str, Any]], tuple[Model, dict[str, Any]]]:
        """Return a function of a variant's parameters: its model, and how it is simulated."""
        return self._described

    def _described(self, parameters: Mapping[str, Any]) -> tuple[Model, dict[str, Any]]:
        result = self.function(**{**self.parameters, **parameters})
        if not isinstance(result, Model):
            raise ModelError(
                self.title,
                found=f"it returns {type(result).__name__}",
                expected="a Model, for the engine 'compiled', which simulates it",
                remedy="Return the model, or leave out the engine",
            )
        return result, self._settings()

    def _settings(self) -> dict[str, Any]:
        """Return how the models of the function are simulated."""
        if self.t_end is None:
            raise ModelError(
                self.title,
                found="it returns a model, and no end time is given",
                expected="t_end in seconds",
                remedy="Give t_end, or let the function simulate and return the solution",
            )
        given = {"samples": self.samples, "time_limit": self.time_limit}
        return {"t_end": self.t_end} | {name: value for name, value in given.items() if value is not None}

    def values(self, parameters: Mapping[str, Any], outputs, folder: Path | None) -> dict[str, float]:
        """Return the numbers of one variant."""
        result = self.function(**{**self.parameters, **parameters})
        if isinstance(result, Model):
            return _simulated(result, self._settings(), outputs, folder)
        if isinstance(result, Solution):
            return _reduced(result, outputs, folder)
        if isinstance(result, Mapping):
            return {str(name): float(value) for name, value in result.items()}
        try:
            return {getattr(self.function, "__name__", "value"): float(result)}
        except (TypeError, ValueError):
            raise ModelError(
                self.title,
                found=f"it returns {type(result).__name__}",
                expected="a Model, a Solution, a number, or a mapping of names to numbers",
                remedy="Return one of these",
            ) from None


def function_in(text: str) -> Callable[..., Any]:
    """Return the function that ``"path/of/module.py:name"`` names; workers import it from the same file."""
    path, _, name = text.rpartition(":")
    file = resolved(path)
    if not file.is_file():
        raise ModelError(
            f"Function '{text}'",
            found=f"there is no file '{path}'",
            expected="path/of/module.py:function",
            remedy="Correct the path",
        )
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(file.parent))  # workers get the path of this process, and find the module by its name
    sys.modules[file.stem] = module
    spec.loader.exec_module(module)
    known = [n for n, f in vars(module).items() if inspect.isfunction(f) and f.__module__ == file.stem]
    _check_known(name, known, f"Function '{text}'", "The file has")
    return getattr(module, name)


def _check_known(name: str, known: Any, part: str, has: str) -> None:
    if name not in known:
        in_file = has == "The file has"
        raise ModelError(
            part,
            found=f"there is no parameter '{name}' to vary",
            expected=f"{has}: {', '.join(known) or 'none'}",
            remedy=did_you_mean(name, known)
            or (f'Add {name} to [parameters], and write "= {name}" where it stands' if in_file else "Correct the name"),
        )


def _simulated(model: Model, settings: Mapping[str, Any], outputs, folder: Path | None) -> dict[str, float]:
    wanted = columns(outputs, model)
    stored = {} if folder is None else {"output": folder / SOLUTION, "write_model": fmb.model_text}
    solution = fmb.simulate(model, **settings, **stored)
    if folder is not None and solution.status.kind != "interrupted":
        fmb.write_table(solution, folder / TABLE)
    require_end(solution)
    return {column.title: column.value(solution) for column in wanted}


def require_end(solution: Solution) -> None:
    """Raise what it means for a variant that its run was ended before its time."""
    if solution.status.kind == "interrupted":
        raise KeyboardInterrupt
    if solution.status.kind == "limited":
        raise FlexmbError(
            f"Model '{getattr(solution.model, 'name', '?')}'",
            found=solution.status.message,
            expected="a run that comes to its end",
            remedy="Give a larger time_limit, and compute the rows that failed once more",
        )


def _reduced(solution: Solution, outputs, folder: Path | None) -> dict[str, float]:
    if solution.model is None:
        raise FlexmbError(
            "Study",
            found="the function returns a solution without its model",
            expected="a solution with its model",
            remedy="Return what flexmb.simulate returned",
        )
    if folder is not None:
        solution.save(folder / SOLUTION, write_model=fmb.model_text)
        fmb.write_table(solution, folder / TABLE)
    return {column.title: column.value(solution) for column in columns(outputs, solution.model)}
