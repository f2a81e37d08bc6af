"""ClickHouse's engine (chdb) behind the part of its HTTP interface that the store uses.

    python3 chdb_server.py FOLDER PORT [CERTIFICATE KEY]

With a certificate behind TLS, and for those who know the password `word`. Prints the port it listens on: PORT, or a free one if that is 0. Ends when its standard input ends, or at an interrupt.
"""

import os
import ssl
import sys
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from urllib.parse import parse_qs, urlsplit

from chdb import session

SESSION = session.Session(sys.argv[1])


class Handler(BaseHTTPRequestHandler):
    def do_POST(self):
        if len(sys.argv) == 5 and self.headers.get("X-ClickHouse-Key") != "word":
            self.send_response(403)
            self.end_headers()
            self.wfile.write(b"Code: 516. Authentication failed")
            return
        asked = {key: values[0] for key, values in parse_qs(urlsplit(self.path).query, keep_blank_values=True).items()}
        body = self.rfile.read(int(self.headers.get("Content-Length", 0))).decode()
        query = asked["query"] + ("\n" + body if body else "")
        parameters = {key[len("param_"):]: value for key, value in asked.items() if key.startswith("param_")}
        try:
            SESSION.query(f"CREATE DATABASE IF NOT EXISTS {asked['database']}")
            SESSION.query(f"USE {asked['database']}")
            SESSION.query("SET output_format_json_quote_64bit_integers = 0")
            answer, code = SESSION.query(query, "JSONCompactEachRow", params=parameters).bytes(), 200
        except Exception as why:  # noqa: BLE001: whatever it is goes to the client
            answer, code = str(why).encode(), 500
        self.send_response(code)
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_):
        pass


SERVER = HTTPServer(("127.0.0.1", int(sys.argv[2])), Handler)
if len(sys.argv) == 5:
    CONTEXT = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    CONTEXT.load_cert_chain(sys.argv[3], sys.argv[4])
    SERVER.socket = CONTEXT.wrap_socket(SERVER.socket, server_side=True)
threading.Thread(target=SERVER.serve_forever, daemon=True).start()
print(SERVER.server_address[1], flush=True)
try:
    sys.stdin.read()
except KeyboardInterrupt:
    pass
# At once: the engine's own threads may keep an orderly end from ever coming.
os._exit(0)
