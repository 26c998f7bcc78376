"""Which of the program's errors a function raises: itself, or through functions of the program called by name."""

import ast
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

Function = ast.FunctionDef | ast.AsyncFunctionDef
Modules = Mapping[str, ast.Module]
"""Modules by their dotted names, parsed."""


def last_name(node: ast.expr) -> str:
    """The name of an exception or a class, without its module and arguments."""
    return ast.unparse(node.func if isinstance(node, ast.Call) else node).split(".")[-1]


class RaisedErrors:
    """The program, and the errors that its functions raise.

    Errors that pass through a name in `own_arguments` are about arguments that are written in the program.
    """

    def __init__(self, modules: Modules, own_arguments: frozenset[str] = frozenset()) -> None:
        self.modules, self.own_arguments = modules, own_arguments
        self._found: dict[tuple[str, int], frozenset[str]] = {}

    @cached_property
    def above(self) -> dict[str, set[str]]:
        """`FieldkitError` and every class below it, each with itself and the classes above it."""
        bases = {
            node.name: [last_name(base) for base in node.bases]
            for tree in self.modules.values()
            for node in tree.body
            if isinstance(node, ast.ClassDef)
        }
        found = {"FieldkitError": {"FieldkitError"}}
        while new := {name: above for name, above in bases.items() if name not in found and found.keys() & {*above}}:
            found |= {name: {name}.union(*(found.get(one, set()) for one in above)) for name, above in new.items()}
        return found

    @cached_property
    def _functions(self) -> dict[tuple[str, str], Function]:
        return {
            (module, node.name): node
            for module, tree in self.modules.items()
            for node in tree.body
            if isinstance(node, Function)
        }

    @cached_property
    def _imports(self) -> dict[tuple[str, str], tuple[str, str]]:
        return {
            (module, name.asname or name.name): (node.module, name.name)
            for module, tree in self.modules.items()
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module
            for name in node.names
        }

    def _called(self, module: str, name: str) -> tuple[str, Function] | None:
        """The function that a name in a module means, and the module it is in."""
        place = (module, name)
        while place not in self._functions and place in self._imports:
            place = self._imports[place]
        return (place[0], self._functions[place]) if place in self._functions else None

    def of(self, module: str, function: Function, *, calls: bool = True) -> frozenset[str]:
        """Names of the errors that leave a function; without `calls` only those that it raises itself."""
        if not calls:
            return frozenset(
                last_name(node.exc) for node in ast.walk(function) if isinstance(node, ast.Raise) and node.exc
            ) & frozenset(self.above)
        key = (module, function.lineno)
        if key not in self._found:
            self._found[key] = frozenset()  # what it raises through itself is raised elsewhere
            self._found[key] = frozenset(self._leaving(module, function.body))
        return self._found[key]

    def _leaving(self, module: str, nodes: Sequence[ast.AST]) -> Iterator[str]:
        for node in nodes:
            if isinstance(node, Function | ast.Lambda | ast.ClassDef):
                continue
            if isinstance(node, ast.Try):
                yield from (error for error in self._leaving(module, node.body) if not self._caught(error, node))
                yield from self._leaving(module, [*node.handlers, *node.orelse, *node.finalbody])
                continue
            if isinstance(node, ast.Raise) and node.exc is not None and last_name(node.exc) in self.above:
                yield last_name(node.exc)
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Name)
                and node.func.id not in self.own_arguments
            ):
                called = self._called(module, node.func.id)
                yield from self.of(*called) if called else ()
            if not (isinstance(node, ast.With) and "suppress(" in ast.unparse(node.items[0])):
                yield from self._leaving(module, list(ast.iter_child_nodes(node)))

    def _caught(self, error: str, attempt: ast.Try) -> bool:
        """Whether a `try` catches an error."""
        for handler in attempt.handlers:
            kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
            names = {last_name(kind) for kind in kinds if kind is not None}
            if not names or names & (self.above[error] | {"Exception"}):
                return True
        return False
