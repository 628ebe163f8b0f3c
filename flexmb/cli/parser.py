"""The parser of the command line: what is wrong with an option is said in words, with the one that was meant."""

from __future__ import annotations

import argparse
import re
from typing import NoReturn

from flexmb.errors import did_you_mean

__all__ = ["Parser"]

NO_NUMBER = re.compile(r"argument (?P<names>\S+): invalid (?P<kind>float|int) value: (?P<value>.*)", re.DOTALL)
NO_CHOICE = re.compile(
    r"argument (?P<what>\S+): invalid choice: '(?P<given>.*?)' \(choose from (?P<known>.*)\)", re.DOTALL
)
KINDS = {"float": "number", "int": "whole number"}


class Parser(argparse.ArgumentParser):
    """argparse's, whose messages about options and numbers say what was expected."""

    def parse_args(self, args=None, namespace=None):  # type: ignore[override]
        """Return the arguments; an unknown option ends the process, as argparse does, with the one that is like it."""
        given, unknown = self.parse_known_args(args, namespace)
        if unknown:
            _of_verb(self, getattr(given, "verb", None)).refuse(unknown)
        return given

    def refuse(self, unknown: list[str]) -> NoReturn:
        """End the process with what this parser does not know."""
        name = unknown[0].partition("=")[0]
        if not name.startswith("-"):
            self.error(f"'{name}' is one argument too many. Put texts with blanks into quotation marks")
        meant = did_you_mean(name, self._option_string_actions) or f"`{self.prog} --help` lists the options."
        self.error(f"there is no option {name}. {meant}")

    def error(self, message: str) -> NoReturn:
        """End the process with a message; one about a number says what the option means, one about a word its like."""
        told = NO_NUMBER.fullmatch(message)
        if told is not None:
            action = self._option_string_actions.get(told["names"].partition("/")[0])
            meant = f": {action.help}" if action is not None and action.help else ""
            message = f"{told['names']}: {told['value']} is no {KINDS[told['kind']]}. Expected{meant or ': a number'}"
        told = NO_CHOICE.fullmatch(message)
        if told is not None and (meant := did_you_mean(told["given"], re.findall(r"[\w.-]+", told["known"]))):
            message = f"{message}. {meant}"
        super().error(message)


def _of_verb(parser: Parser, verb: str | None) -> Parser:
    """Return the parser of a verb."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction) and verb in action.choices:
            return action.choices[verb]
    return parser
