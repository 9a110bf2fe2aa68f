"""Who may come in: by the address that was asked for, where the page is from, and the token."""

from __future__ import annotations

import hmac
import ipaddress
from urllib.parse import urlsplit

LOOPBACK = ("localhost", "127.0.0.1", "::1")


def is_loopback(host: str) -> bool:
    """Return whether only programs of the same machine reach `host`."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def is_any(host: str) -> bool:
    """Return whether `host` stands for every address of the machine."""
    try:
        return ipaddress.ip_address(host).is_unspecified
    except ValueError:
        return False


def host_of(authority: str) -> str:
    """Return the host of ``host:port``, in lower case; empty if it is no such thing."""
    try:
        return urlsplit(f"//{authority}").hostname or ""
    except ValueError:
        return ""


class Access:
    """Decides on requests.

    Parameters
    ----------
    host : str
        What the server listens at.
    token : str
        The first part of every path; empty: none is asked for.
    """

    def __init__(self, host: str, token: str) -> None:
        self.token = token
        self._host = host.lower()

    def refusal(self, host: str, origin: str | None, path: str) -> str:
        """Return why a request is refused; empty if it is not.

        Parameters
        ----------
        host : str
            The header: a page of somebody else's whose name leads to this machine (DNS
            rebinding) names itself here.
        origin : str or None
            The header, which browsers send with every websocket: where its page is from.
        """
        if not self._is_ours(host_of(host)):
            return "this server is not at that address"
        if origin is not None and origin.lower().partition("://")[2] != host.lower():
            return "only its own page may talk to this server"
        if self.token and not hmac.compare_digest(
            path[1:].partition("/")[0].encode("utf-8", "replace"), self.token.encode()
        ):
            return "the address has no valid token: use the one that the command has printed"
        return ""

    def _is_ours(self, host: str) -> bool:
        if is_any(self._host):
            # Names and addresses that lead here are not known; the token is.
            return host != ""
        return host == self._host or (is_loopback(self._host) and host in LOOPBACK)
