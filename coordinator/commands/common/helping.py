"""How the help of `heavylift` looks: commands by what they are about, each with an example that can be copied.

A command's docstring is `What it does.    heavylift name ...`: what stands behind the four blanks is its example and
is printed on a line of its own.  Commands stand below the heading of the file that they are written in.
"""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand, TyperGroup

MARK = "    heavylift "
HEADINGS = {
    "scenes": "Scenes",
    "running": "Runs",
    "sweeping": "Runs",
    "limiting": "Runs",
    "operating": "Runs that go on",
    "files": "Recordings",
    "measuring": "Recordings",
    "replaying": "Recordings",
    "own_models": "Models of your own",
    "hosts": "Several hosts",
    "health": "Installation",
}


class Spared:
    """Typer converts by Pydantic, whose import takes long: what needs no conversion is spared it."""

    get_params: Any

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As typer does."""
        for param in self.get_params(ctx):
            if getattr(param, "_runtime_param", param) is None:
                vars(param)["_runtime_param"] = _AsGiven()
        return super().parse_args(ctx, args)  # type: ignore[misc,no-any-return]


class _AsGiven:
    """Leaves the value of a parameter as it is: nothing, its default, or text where text is wanted."""

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        wanted = param.type_descriptor
        if value is None:
            return () if param.multiple else None
        if value == param.default or (wanted.annotation in (str, list[str]) and wanted.parameter_info.parser is None):
            return value
        param._runtime_param = None
        return param.get_runtime_param().coerce(value, param=param, ctx=ctx)


class Command(Spared, TyperCommand):
    """A command with its example behind its options."""

    def __init__(self, *arguments: str | None, help: str | None = None, **settings: Any) -> None:
        told, mark, rest = (help or "").partition(MARK)
        example, _, more = rest.partition("\n")
        settings["short_help"] = told.strip()
        super().__init__(*arguments, help=f"{told}\n{more}".strip(), **settings)
        self.example = f"{mark}{example}".strip()

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """The example, not wrapped."""
        if self.example:
            with formatter.section("Example"):
                formatter.write(f"  {self.example}\n")
        super().format_epilog(ctx, formatter)


class CommandList(Spared, TyperGroup):
    """All commands, by heading."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """A list of commands per heading; each with all that its first sentence says."""
        by_heading: dict[str, list[tuple[str, str]]] = {heading: [] for heading in HEADINGS.values()}
        for name, command in self.commands.items():
            module = getattr(command.callback, "__module__", "").rpartition(".")[2]
            by_heading[HEADINGS[module]].append((name, command.get_short_help_str(limit=formatter.width)))
        for heading, rows in by_heading.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)
