"""Who may read the page: the page itself and programs of this machine, no other web site in the same browser."""

from __future__ import annotations

import socket
from collections.abc import Iterator

import pytest
from served import free_port, get, start_dashboard
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

POLLING = "/_nicegui_ws/socket.io/?EIO=4&transport=polling"
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport=websocket"
FOREIGN = ["http://elsewhere.example", "null", "http://localhost:1", "https://{own}", "http://{own}.elsewhere.example"]

pytestmark = pytest.mark.live


@pytest.fixture(scope="module")
def port(tmp_path_factory: pytest.TempPathFactory) -> Iterator[int]:
    port = free_port()
    process = start_dashboard(port, tmp_path_factory.mktemp("dashboard"))
    try:
        get(port)
        yield port
    finally:
        process.kill()
        process.communicate()


def opened(port: int, host: str, origin: str | None) -> ClientConnection:
    """A websocket to the page, asked for under a name of its machine as a browser would."""
    there = socket.create_connection(("127.0.0.1", port))
    return connect(f"ws://{host}:{port}{SOCKET}", sock=there, origin=origin, proxy=None)  # type: ignore[arg-type]


@pytest.mark.parametrize("path", ["/", POLLING, POLLING + "&j=0", "/favicon.ico"])
@pytest.mark.parametrize("origin", FOREIGN)
def test_another_site_reads_nothing(port: int, path: str, origin: str):
    answer = get(port, path, origin=origin.format(own=f"127.0.0.1:{port}"))
    assert answer.status_code == 403
    assert "access-control-allow-origin" not in answer.headers
    assert "warehouse" not in answer.text and "sid" not in answer.text


@pytest.mark.parametrize("origin", FOREIGN)
def test_another_site_opens_no_websocket(port: int, origin: str):
    with pytest.raises(InvalidStatus) as refused, opened(port, "127.0.0.1", origin.format(own=f"127.0.0.1:{port}")):
        pass
    assert refused.value.response.status_code == 403


@pytest.mark.parametrize("host", ["elsewhere.example", "127.0.0.1.elsewhere.example", "0.0.0.0"])
def test_a_name_that_was_bound_to_this_machine_from_outside_is_refused(port: int, host: str):
    own = f"{host}:{port}"
    for path in ("/", POLLING):
        assert get(port, path, host=own).status_code == 400
        assert get(port, path, host=own, origin=f"http://{own}").status_code == 400
    with pytest.raises(InvalidStatus) as refused, opened(port, host, f"http://{own}"):
        pass
    assert refused.value.response.status_code == 400


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_the_page_itself_may_read_and_open_its_websocket(port: int, host: str):
    own = f"{host}:{port}"
    assert get(port, host=own, sec_fetch_site="none").status_code == 200
    assert get(port, POLLING, host=own, origin=f"http://{own}", sec_fetch_site="same-origin").status_code == 200
    with opened(port, host, f"http://{own}") as page:
        assert '"sid"' in str(page.recv(timeout=5.0))


def test_a_program_of_this_machine_names_no_site_and_is_answered(port: int):
    assert get(port).status_code == 200
    assert get(port, POLLING).status_code == 200
    with opened(port, "127.0.0.1", None) as program:
        assert '"sid"' in str(program.recv(timeout=5.0))


def test_scripts_and_pictures_of_another_site_are_refused_and_links_are_followed(port: int):
    foreign = {"sec_fetch_site": "cross-site"}
    assert get(port, POLLING + "&j=0", **foreign, sec_fetch_mode="no-cors", sec_fetch_dest="script").status_code == 403
    assert get(port, **foreign, sec_fetch_mode="navigate", sec_fetch_dest="iframe").status_code == 403
    assert get(port, **foreign, sec_fetch_mode="navigate", sec_fetch_dest="document").status_code == 200


@pytest.mark.parametrize("origin", [None, "http://elsewhere.example"])
def test_no_answer_may_be_framed_or_load_anything_from_elsewhere(port: int, origin: str | None):
    headers = get(port, **({"origin": origin} if origin else {})).headers
    assert headers["x-frame-options"] == "DENY"
    policy = dict(part.split(" ", 1) for part in headers["content-security-policy"].split("; "))
    assert policy["default-src"] == policy["frame-ancestors"] == policy["form-action"] == "'none'"
    assert not [allowed for allowed in policy.values() if "*" in allowed or "http" in allowed]
