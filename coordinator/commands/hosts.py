"""Commands of runs over several hosts: node, certificates."""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from heavylift.coordinator.commands.common import options as o
from heavylift.coordinator.commands.common.app import app
from heavylift.kernel.errors import SceneError

if TYPE_CHECKING:
    from heavylift.coordinator.hosts.listener import RemoteListener


def open_listener(
    remote: frozenset[str], listen: str, keys: Path, in_process: bool, external: Iterable[str] = ()
) -> "RemoteListener | None":
    """Return the listener of a run with remote processes; None if the run has none."""
    from heavylift.coordinator.hosts.certificates import COORDINATOR, Credentials
    from heavylift.coordinator.hosts.listener import RemoteListener

    names = ", ".join(sorted(remote))
    if in_process and (programs := ", ".join(sorted(external))):
        raise SceneError(
            f"--in-process: process {programs} is an external program; leave out --in-process or --external"
        )
    if in_process and remote:
        raise SceneError(f"--in-process: process {names} is placed on another host; leave out --in-process or --remote")
    if remote and not listen:
        message = f"process {names} runs on another host, say where it can reach this one"
        raise SceneError(f"{message}: --listen tls/ADDRESS:7447")
    if listen and not remote:
        raise SceneError(f"--listen {listen}: no process runs on another host; name one with --remote")
    return RemoteListener.at(listen, Credentials.load(keys, COORDINATOR)) if remote else None


@app.command()
def certificates(
    directory: Annotated[Path, typer.Argument(help="where keys and certificates are kept")],
    names: Annotated[list[str], typer.Argument(help="processes that run on other hosts")],
    hosts: Annotated[
        list[str] | None, typer.Option("--host", help="name or address by which others reach the coordinator")
    ] = None,
    days: Annotated[int, typer.Option("--days", min=1, help="how long they are valid")] = 365,
) -> None:
    """Create keys for processes on other hosts.    heavylift certificates keys west east --host 192.168.1.10"""
    from heavylift.coordinator.hosts.certificates import make_certificates

    written = make_certificates(directory, names, hosts or [], days)
    for path in written:
        typer.echo(f"wrote {path}")
    for name in names:
        typer.echo(f"process {name} needs yard.pem, {name}.pem and {name}.key of {directory} on its host")


@app.command()
def node(
    name: Annotated[str, typer.Argument(help="process of the run, as the coordinator names it")],
    connect: Annotated[str, typer.Option("--connect", help="tls/HOST:PORT of the coordinator")],
    keys: o.Certificates = Path("certificates"),
    run: Annotated[str, typer.Option("--run", help="join this run and no other")] = "",
    scene: Annotated[str, typer.Option("--scene", help="join only if this scene is run")] = "",
    sets: o.Sets = None,
) -> None:
    """Join a run as a remote process.    heavylift node east --connect tls/192.168.1.10:7447 --certificates keys"""
    from heavylift.coordinator.hosts.certificates import Credentials
    from heavylift.coordinator.hosts.listener import RemoteListener
    from heavylift.coordinator.hosts.remote_node import play

    wanted = ""
    if scene:
        from heavylift.coordinator.participants.parts import fingerprint
        from heavylift.nodes.plan.plan import encode

        wanted = fingerprint(encode(o.scene_of(scene, sets).plan))
    sys.path.append(os.getcwd())  # for a model's module; it runs only if its code is trusted here
    listener = RemoteListener.at(connect, Credentials.load(keys, name))
    play(name, listener, run, wanted, lambda message: typer.echo(message, err=True))
