//! Promise: a box that is not there, and one that goes away, are one line with the port, what
//! happened and what to do.

use host_tests::files::Folder;
use host_tests::process::{Ended, Rarma};
use host_tests::rarma;
use host_tests::refusal::assert_one_line;
use std::net::TcpListener;
use std::thread;

fn program() -> Rarma {
    rarma!()
}

fn both(port: &str) -> [Ended; 2] {
    ["decode", "connect"].map(|command| program().run([command, port]))
}

#[test]
fn what_is_no_port_is_refused_by_name() {
    let folder = Folder::default();
    let gone = TcpListener::bind("127.0.0.1:0").expect("a port");
    let nobody = format!("tcp:{}", gone.local_addr().expect("its address"));
    drop(gone);
    let missing = folder.path().join("ttyNONE").display().to_string();
    let directory = folder.path().display().to_string();
    for (port, words) in [
        (nobody.as_str(), ["nobody listens", "start the box or"]),
        ("tcp:box", ["not an address", "tcp:HOST:PORT"]),
        ("tcp:127.0.0.1:many", ["not an address", "tcp:HOST:PORT"]),
        (&missing, ["no such file or port", "plugged in"]),
        (&directory, ["is a directory", "name one file"]),
        (
            "/dev/null",
            ["neither a file nor a serial port", "tcp:HOST:PORT"],
        ),
    ] {
        for ended in both(port) {
            assert_one_line(&ended, 3, port, &words);
        }
    }
}

/// A server that closes while bytes wait for it: the system says "connection reset by peer"
/// or "broken pipe", whichever end notices first.
#[test]
fn a_connection_that_is_cut_says_so() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = format!("tcp:{}", listener.local_addr().expect("its address"));
    let server = thread::spawn(move || {
        let (socket, _) = listener.accept().expect("a caller");
        // Something of the caller's has come, and is never read.
        socket.peek(&mut [0]).expect("its first byte");
    });
    let ended = program().run(["connect", &port, "--seconds", "20"]);
    server.join().expect("it closed");
    let words = ["the other end closed the connection", "connect again"];
    assert_one_line(&ended, 4, &port, &words);
}

#[test]
fn input_without_a_frame_says_where_it_ended() {
    let folder = Folder::default();
    for bytes in [&b""[..], b"no frames here\0at all\0", &[0; 100]] {
        let file = folder.file("noise.bin", bytes);
        let name = file.display().to_string();
        let ended = program().run(["decode", &name]);
        assert_one_line(&ended, 3, &name, &["end of input", "no whole frame"]);
    }
}
