//! What is said of the way, and what is refused.

use super::*;

fn refused(place: &str) -> String {
    taken_from(place).unwrap_err().to_string()
}

#[test]
fn settings_of_the_way_are_taken_out_and_others_stay() {
    let tls = |file: &str| Way::Tls(PathBuf::from(file));
    for (place, address, way) in [
        ("postgres://u:p@h/d", "postgres://u:p@h/d", Way::Unsaid),
        ("u:a?b@h/d", "u:a?b@h/d", Way::Unsaid),
        ("u:a?b=c@h/d", "u:a?b=c@h/d", Way::Unsaid),
        ("h/d?sslmode=disable", "h/d", Way::Clear),
        (
            "u:a?b@h/d?connect_timeout=3&sslrootcert=/etc/a%40b%20c.pem&options=x",
            "u:a?b@h/d?connect_timeout=3&options=x",
            tls("/etc/a@b c.pem"),
        ),
        (
            "h/d?sslmode=verify-full&sslrootcert=100%.pem",
            "h/d",
            tls("100%.pem"),
        ),
    ] {
        assert_eq!(taken_from(place).unwrap(), (address.to_owned(), way));
    }
    assert!(refused("h/d?sslmode=disable&sslrootcert=a").contains("contradict"));
    for mode in [
        "prefer",
        "allow",
        "require",
        "verify-ca",
        "verify-full",
        "x",
    ] {
        let said = refused(&format!("h/d?sslmode={mode}"));
        assert!(said.contains("sslrootcert=FILE"), "{said}");
    }
    assert!(refused("h/d?sslmode=prefer&sslrootcert=a").contains("prefer"));
}

#[test]
fn in_clear_only_here_or_where_it_was_said() {
    for here in [
        "localhost",
        "127.0.0.1",
        "127.1.2.3",
        "::1",
        "[::1]",
        "/run/postgresql",
        "",
    ] {
        assert!(Way::Unsaid.allows(here).is_ok(), "{here}");
    }
    for there in [
        "db.plant",
        "10.0.0.7",
        "localhost.plant",
        "127.0.0.1.plant",
        "[fe80::1]",
        "0.0.0.0",
    ] {
        let said = Way::Unsaid.allows(there).unwrap_err().to_string();
        assert!(
            said.starts_with(there) && said.contains("in clear"),
            "{said}"
        );
        assert!(Way::Clear.allows(there).is_ok() && Way::Tls("a".into()).allows(there).is_ok());
    }
}
