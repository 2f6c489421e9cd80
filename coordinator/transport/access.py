"""Who may do what on a run's bus: the access control of the coordinator's session.

What is not allowed here is denied, in silence on the side of the one who tried.  Passwords and certificates tell who
somebody is; the messages are those of Zenoh, the flows are seen from the coordinator.
"""

from __future__ import annotations

from typing import Any

from .keys import AFAR, HUB, JOIN, OBSERVER, OPERATOR, key


def access(run: str, processes: list[str], remote: tuple[str, ...]) -> dict[str, object]:
    """Each process writes its nodes' keys and hears them; an observer hears events; all else is denied.

    A process of this host is known by its password, one of another host by the name in its certificate; whoever
    has a certificate of the yard may ask whether it may join, and join under the name in it.
    """

    def rule(name: str, flow: str, messages: list[str], *keys: str) -> dict[str, Any]:
        return {
            "id": name,
            "permission": "allow",
            "flows": [flow],
            "messages": messages,
            "key_exprs": list(keys),
        }

    rules = [
        rule(
            "egress",
            "egress",
            ["put", "declare_subscriber", "declare_queryable", "liveliness_token", "reply", "query"],
            key(run, "**"),
            key(JOIN, "*"),
        ),
        rule("join", "ingress", ["query"], key(JOIN, "*")),
        rule("hub", "ingress", ["declare_liveliness_subscriber"], key(run, "alive", HUB)),
        rule("observe", "ingress", ["declare_subscriber"], key(run, "event", "**"), key(run, "sample", "**")),
    ]
    rules.append(rule("operate", "ingress", ["query"], key(run, "control")))
    policies = [
        {"rules": ["observe", "egress"], "subjects": [OBSERVER]},
        {"rules": ["operate", "egress"], "subjects": [OPERATOR]},
    ]
    for process in (*processes, *remote):
        out, into = [key(run, topic, process, "*") for topic in ("out", "samples")], key(run, "in", process, "*")
        own = [
            rule(f"{process}/out", "ingress", ["put"], *out),
            rule(f"{process}/alive", "ingress", ["liveliness_token"], key(run, "alive", process, "*")),
            rule(f"{process}/ask", "ingress", ["declare_queryable", "reply"], key(run, "ask", process, "*")),
            rule(f"{process}/in", "ingress", ["declare_subscriber"], into),
            rule(f"{process}/leave", "ingress", ["query"], key(run, "leave", process), key(run, "enter", process)),
        ]
        rules += own
        policies.append({"rules": [*(each["id"] for each in own), "hub", "egress"], "subjects": [process]})
    here, afar = {"link_protocols": ["unixsock-stream"]}, {"link_protocols": ["tls"]}
    users = (*processes, OBSERVER, OPERATOR)
    subjects: list[dict[str, object]] = [{"id": user, "usernames": [user], **here} for user in users]
    subjects += [{"id": process, "cert_common_names": [process], **afar} for process in remote]
    if remote:
        subjects.append({"id": AFAR, **afar})
        policies.append({"rules": ["join", "egress"], "subjects": [AFAR]})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": subjects,
        "policies": policies,
    }
