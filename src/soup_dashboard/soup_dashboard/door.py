"""Who may read the page: programs on this machine and the page itself, no other web site in the same browser.

A browser sends requests to 127.0.0.1 on behalf of any site that a person has open. Three things give such a request
away: a `Host` that is not this machine's (DNS rebinding), an `Origin` that is not the page's own, and `Sec-Fetch-Site`.
A request with none of them comes from a program, which could do as it likes anyway. The headers of the answers keep the
page out of frames, and its scripts and connections on this machine.
"""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

OWN_SITES = ("same-origin", "none")  # of `Sec-Fetch-Site`; none: a person typed the address
POLICY = {
    "default-src": "'none'",
    "script-src": "'self' 'unsafe-inline' 'unsafe-eval'",  # NiceGUI writes scripts into the page and compiles templates
    "style-src": "'self' 'unsafe-inline'",
    "img-src": "'self' data:",
    "font-src": "'self'",
    "connect-src": "'self'",
    "base-uri": "'none'",
    "form-action": "'none'",
    "frame-ancestors": "'none'",
}
HEADERS = {
    "Content-Security-Policy": "; ".join(f"{what} {allowed}" for what, allowed in POLICY.items()),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}


class Door:
    """ASGI middleware around everything that is served, websockets too."""

    def __init__(self, app: ASGIApp, names: list[str]) -> None:
        """Guard an application.

        Args:
            app: What answers those who may ask.
            names: Of this machine; a `Host` may name any port, since a tunnel may end at another one.
        """
        self._app = TrustedHostMiddleware(app, allowed_hosts=names, www_redirect=False)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request or connection."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return

        async def send_guarded(message: Message) -> None:
            if message["type"] in ("http.response.start", "websocket.http.response.start"):
                message.setdefault("headers", [])
                MutableHeaders(scope=message).update(HEADERS)
            await send(message)

        found = _foreign(scope, Headers(scope=scope))
        if found:
            answer = PlainTextResponse(f"found {found}; allowed: this page itself, opened by its address\n", 403)
            await answer(scope, receive, send_guarded)
        else:
            await self._app(scope, receive, send_guarded)


def _foreign(scope: Scope, headers: Headers) -> str:
    """What says that a request was sent for another web site; empty where nothing does."""
    own = f"http://{headers.get('host', '')}"
    for origin in headers.getlist("origin"):
        if origin != own:
            return f"Origin {origin[:100]}"
    site = headers.get("sec-fetch-site", "none")
    if site not in OWN_SITES and not _is_link(scope, headers):
        return f"Sec-Fetch-Site {site[:100]}"
    return ""


def _is_link(scope: Scope, headers: Headers) -> bool:
    """Whether a person followed a link to the page; whose site it was on does not see the answer."""
    in_a_tab = headers.get("sec-fetch-mode") == "navigate" and headers.get("sec-fetch-dest") == "document"
    return in_a_tab and scope.get("method") == "GET" and scope["path"] == "/"
