//! TLS to databases: with the plant's certificates, and with no others. In clear nothing leaves this computer
//! unless it was said.

mod support;

use rarma_fleet::record::from_line;
use rarma_fleet::store::{Store, StoreError};
use support::Certificates;

const LINE: &str = r#"{"schema":1,"box":"b","session":1,"seq":1,"machine":"M","time":"2026-01-01T00:00:00Z","kind":"alarm-called","body":{"f_hz":1.0,"zeta":0.0}}"#;

/// Whether a store is opened by a program that has a password in its environment.
fn opened_with(variable: &str, word: &str, place: &str) -> bool {
    let child = std::process::Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "opens_what_it_is_told"])
        .env(variable, word)
        .env("RARMA_TEST_PLACE", place)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&child.stdout);
    assert!(
        said.contains("1 passed") || said.contains("1 failed"),
        "{said}"
    );
    child.status.success()
}

/// A part of the tests below, in a program of its own: alone it opens nothing.
#[test]
fn opens_what_it_is_told() {
    if let Ok(place) = std::env::var("RARMA_TEST_PLACE") {
        Store::open(&place).unwrap();
    }
}

fn refused(place: &str) -> StoreError {
    Store::open(place).err().expect(place)
}

/// Takes a record, and has it when it is opened anew.
fn works(place: &str) {
    let record = from_line(LINE).unwrap();
    assert_eq!(Store::open(place).unwrap().add(&[record]).unwrap().new, 1);
    let lines = Store::open(place)
        .unwrap()
        .lines(None, None, None, 10)
        .unwrap();
    assert_eq!(lines.len(), 1);
}

/// What is refused of a server that speaks TLS; `scheme` with its user, `rest` the database.
fn only_with_its_certificates(scheme: &str, port: u16, rest: &str, own: &Certificates) {
    let place = |host: &str, file: &std::path::Path| {
        format!(
            "{scheme}{host}:{port}/{rest}?sslrootcert={}",
            file.display()
        )
    };
    works(&place("localhost", &own.file("ca.pem")));
    // Signed by somebody else; by somebody else who has the same name.
    for (signer, reason) in [("other", "UnknownIssuer"), ("plant", "BadSignature")] {
        let ca = Certificates::signed_by(signer).unwrap();
        let said = refused(&place("localhost", &ca.file("ca.pem"))).to_string();
        let file = ca.file("ca.pem").display().to_string();
        assert!(said.contains(reason) && said.contains(&file), "{said}");
    }
    // Signed as it should be, but of another name.
    let said = refused(&place("127.0.0.1", &own.file("ca.pem"))).to_string();
    assert!(
        said.contains("not valid for name") && said.contains("the name that was asked for"),
        "{said}"
    );
    assert!(!said.contains('\n'), "{said}");
    let none = own.file("none.pem");
    let said = refused(&place("localhost", &none));
    assert!(matches!(said, StoreError::Way(_)), "{said}");
    assert!(said.to_string().contains("none.pem"), "{said}");
    let said = refused(&place("localhost", &own.file("server.key"))).to_string();
    assert!(said.contains("no certificate in it"), "{said}");
}

#[test]
fn postgres_with_the_certificates_of_the_plant_and_no_others() {
    let Some(own) = Certificates::signed_by("plant") else {
        return;
    };
    let Some(server) = support::postgres_with(Some(&own)) else {
        return;
    };
    only_with_its_certificates("postgres://rarma@", server.port, "postgres", &own);
    // A password is bound to this very connection (SCRAM with channel binding); out of the address or the environment.
    let of = |login: &str| {
        format!(
            "postgres://{login}@localhost:{}/template1?sslrootcert={}",
            server.port,
            own.file("ca.pem").display()
        )
    };
    works(&of("rarma:word"));
    let said = refused(&of("rarma:other")).to_string();
    assert!(said.contains("password authentication failed"), "{said}");
    assert!(opened_with("PGPASSWORD", "word", &of("rarma")));
    assert!(!opened_with("PGPASSWORD", "other", &of("rarma")));
    // It speaks to nobody in clear: what worked above was TLS.
    let clear = format!("postgres://rarma@localhost:{}/postgres", server.port);
    for place in [clear.clone(), format!("{clear}?sslmode=disable")] {
        let said = refused(&place).to_string();
        assert!(said.contains("no encryption"), "{said}");
    }
}

#[test]
fn clickhouse_with_the_certificates_of_the_plant_and_no_others() {
    let Some(own) = Certificates::signed_by("plant") else {
        return;
    };
    let Some(server) = support::clickhouse_with(Some(&own)) else {
        return;
    };
    only_with_its_certificates("clickhouse://rarma:word@", server.port, "plant", &own);
    let of = |login: &str| {
        format!(
            "clickhouse://{login}@localhost:{}/plant?sslrootcert={}",
            server.port,
            own.file("ca.pem").display()
        )
    };
    let said = refused(&of("rarma:other")).to_string();
    assert!(said.contains("Authentication failed"), "{said}");
    assert!(opened_with("CLICKHOUSE_PASSWORD", "word", &of("rarma")));
    assert!(!opened_with("CLICKHOUSE_PASSWORD", "other", &of("rarma")));
    let clear = format!("clickhouse://localhost:{}/plant", server.port);
    assert!(matches!(refused(&clear), StoreError::Database(_)));
}

#[test]
fn a_server_without_tls_gets_nothing_where_tls_was_asked_for() {
    let (Some(own), Some(server)) = (Certificates::signed_by("plant"), support::postgres()) else {
        return;
    };
    let place = format!(
        "postgres://rarma@localhost:{}/postgres?sslrootcert={}",
        server.port,
        own.file("ca.pem").display()
    );
    let said = refused(&place).to_string();
    assert!(
        said.contains("does not support TLS") && said.contains("postgresql.conf"),
        "{said}"
    );
}

#[test]
fn in_clear_to_another_computer_only_where_it_was_said() {
    for place in [
        "postgres://u:secret@db.invalid/plant",
        "postgres://u:secret@localhost,db.invalid/plant",
        "postgres://u:secret@localhost/plant?hostaddr=192.0.2.1",
        "clickhouse://u:secret@db.invalid/plant",
        "clickhouse://u:secret@db.invalid:8123/plant",
        "clickhouse://u:secret@[2001:db8::1]:8123/plant",
    ] {
        let why = refused(place);
        assert!(matches!(why, StoreError::Way(_)), "{place}: {why}");
        let said = why.to_string();
        assert!(
            said.contains("in clear")
                && said.contains("sslrootcert=FILE")
                && !said.contains("secret"),
            "{said}"
        );
    }
    // Said, it is tried: there is no such computer.
    for place in [
        "postgres://u@db.invalid/plant?sslmode=disable",
        "clickhouse://u@db.invalid/plant?sslmode=disable",
    ] {
        let why = refused(place);
        assert!(matches!(why, StoreError::Database(_)), "{place}: {why}");
    }
}
