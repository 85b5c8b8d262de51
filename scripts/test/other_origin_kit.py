"""A page of another origin, from the same host: a browser sends it the cookie of the first one."""

from __future__ import annotations

import contextlib
import ssl
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Iterator

# Each returns "refused", or what it has got.
TRIES = """
const [own, done] = arguments;
const late = () => new Promise((end) => setTimeout(end, 5000, "refused"));
const limit = (work) => Promise.race([work, late()]);
const read = async (path, options) => {
  try {
    const answer = await fetch(own + path, { credentials: "include", ...options });
    return answer.type === "opaque" ? "refused" : await answer.text();
  } catch { return "refused"; }
};
const load = (tag, address) => new Promise((end) => {
  const made = document.createElement(tag);
  made.onload = () => end(tag === "iframe" && !made.contentDocument ? "refused" : "loaded");
  made.onerror = () => end("refused");
  made.src = own + address;
  document.body.append(made);
});
const events = () => new Promise((end) => {
  const source = new EventSource(own + "/api/live", { withCredentials: true });
  source.onmessage = ({ data }) => end(data);
  source.onerror = () => { source.close(); end("refused"); };
});
const post = (type) => new Promise((end) => {
  const frame = document.createElement("iframe");
  frame.name = type;
  const form = document.createElement("form");
  Object.assign(form, { method: "post", action: own + "/api/stop", enctype: type, target: type });
  const field = document.createElement("input");
  Object.assign(field, { name: '{"press":"00000000000000000000000000000000","a":"', value: '"}' });
  form.append(field);
  document.body.append(frame, form);
  frame.onload = () => { if (!frame.contentDocument) end("refused"); };
  form.submit();
});
const body = JSON.stringify({ press: "0".repeat(32) });
const json = { "Content-Type": "application/json" };
const all = {
  read: read("/api/me"),
  readBlindly: read("/api/me", { mode: "no-cors" }),
  json: read("/api/stop", { method: "POST", headers: json, body }),
  plain: read("/api/stop", { method: "POST", mode: "no-cors", body }),
  events: events(),
  formPlain: post("text/plain"),
  formUsual: post("application/x-www-form-urlencoded"),
  img: load("img", "/api/ground/bar.png"),
  script: load("script", "/"),
  frame: load("iframe", "/"),
};
Promise.all(Object.entries(all).map(async ([name, one]) => [name, await limit(one)]))
  .then((found) => done(Object.fromEntries(found)));
"""


class _Empty(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        """Answer with an empty page that may do what it likes."""
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>other</title><body>")

    def log_message(self, *_arguments: object) -> None:
        """Write nothing."""


@contextlib.contextmanager
def other_origin(certificate: Path, key: Path) -> Iterator[str]:
    """Serve an empty page at another port of this host; yield its address."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), _Empty)
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.load_cert_chain(str(certificate), str(key))
    server.socket = context.wrap_socket(server.socket, server_side=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"https://localhost:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
