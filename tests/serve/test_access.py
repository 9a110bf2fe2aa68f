"""Who may come in."""

from __future__ import annotations

import pytest

from ssdo_gl.serve.access import Access


@pytest.mark.parametrize(
    ("listens", "token", "host", "origin", "path", "refused"),
    [
        ("127.0.0.1", "", "127.0.0.1:8765", None, "/", ""),
        ("127.0.0.1", "", "localhost:9000", "http://localhost:9000", "/socket", ""),
        ("::1", "", "[::1]:8765", "http://[::1]:8765", "/socket", ""),
        ("127.0.0.1", "", "evil.example:8765", None, "/", "not at that address"),
        ("127.0.0.1", "", "localhost.evil.example", None, "/", "not at that address"),
        ("127.0.0.1", "", "", None, "/", "not at that address"),
        ("127.0.0.1", "", "[::1", None, "/", "not at that address"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://evil.example", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://127.0.0.1:1", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "null", "/socket", "its own page"),
        ("127.0.0.1", "", "127.0.0.1:8765", "http://[::1", "/socket", "its own page"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/secret/", ""),
        ("0.0.0.0", "secret", "box.example:8765", None, "/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/secret2/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "/s\u00e9cret/", "no valid token"),
        ("0.0.0.0", "secret", "box.example:8765", None, "*", "no valid token"),
        ("box.example", "secret", "other.example", None, "/secret/", "not at that address"),
        ("box.example", "secret", "BOX.example:80", "http://box.example:80", "/secret/", ""),
    ],
)
def test_only_those_who_know_the_address_come_in(listens, token, host, origin, path, refused):
    refusal = Access(listens, token).refusal(host, origin, path)
    assert (refused in refusal) if refused else refusal == ""
