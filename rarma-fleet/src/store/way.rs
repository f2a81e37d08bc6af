//! The way to a database: with TLS, or in clear where that is no risk or was said.
//!
//! Both kinds of database take the same two settings behind their address, as PostgreSQL's own programs spell
//! them: `?sslrootcert=FILE` and `?sslmode=disable`.

use super::backend::StoreError;
use std::net::IpAddr;
use std::path::PathBuf;

/// How a database is reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Way {
    /// With TLS, trusting these certificates only (PEM).
    Tls(PathBuf),
    /// In clear, for it was said so.
    Clear,
    /// Nothing was said: in clear on this computer, and nowhere else.
    Unsaid,
}

/// An address without `sslmode` and `sslrootcert`, and what they say.
///
/// # Errors
/// [`StoreError::Way`]: they contradict each other, or ask for what this program does not do.
pub(super) fn taken_from(place: &str) -> Result<(String, Way), StoreError> {
    // A password may hold a `?`; settings are behind the last one.
    let Some((address, settings)) = place
        .rsplit_once('?')
        .filter(|(_, settings)| settings.contains('=') && !settings.contains('@'))
    else {
        return Ok((place.to_owned(), Way::Unsaid));
    };
    let (mut mode, mut root, mut others) = (None, None, Vec::new());
    for setting in settings.split('&') {
        match setting.split_once('=') {
            Some(("sslmode", value)) => mode = Some(value),
            Some(("sslrootcert", value)) => root = Some(decoded(value)),
            _ => others.push(setting),
        }
    }
    let way = match (mode, root) {
        (Some("disable"), Some(_)) => {
            return Err(StoreError::Way(
                "sslmode=disable and sslrootcert contradict each other (leave one out)".to_owned(),
            ));
        }
        (Some("disable"), None) => Way::Clear,
        // Whichever it is: the certificate and its name are checked.
        (None | Some("require" | "verify-ca" | "verify-full"), Some(root)) => {
            Way::Tls(PathBuf::from(root))
        }
        (None, None) => Way::Unsaid,
        (Some(mode), _) => {
            return Err(StoreError::Way(format!(
                "sslmode={mode} does not say who may answer (write sslrootcert=FILE with the plant's certificates; in clear: sslmode=disable)"
            )));
        }
    };
    let address = if others.is_empty() {
        address.to_owned()
    } else {
        format!("{address}?{}", others.join("&"))
    };
    Ok((address, way))
}

impl Way {
    /// Whether the way may be gone to a host.
    ///
    /// # Errors
    /// [`StoreError::Way`]: it would be in clear to another computer, and nobody said so.
    pub(super) fn allows(&self, host: &str) -> Result<(), StoreError> {
        if *self != Self::Unsaid || is_here(host) {
            return Ok(());
        }
        Err(StoreError::Way(format!(
            "{host} is another computer, and passwords and records would go there in clear (write ?sslrootcert=FILE with the plant's certificates; where the way is safe, ?sslmode=disable)"
        )))
    }

    /// What is to be looked at where TLS failed; nothing where none is spoken.
    pub(super) fn doubt(&self, said: &str) -> String {
        match self {
            Self::Tls(root) if said.contains("ertificate") => format!(
                " (is the server's certificate signed by one in {}, and does it have the name that was asked for?)",
                root.display()
            ),
            Self::Tls(_) if said.contains("does not support TLS") => {
                " (turn it on there: ssl, ssl_cert_file and ssl_key_file in postgresql.conf)"
                    .to_owned()
            }
            _ => String::new(),
        }
    }
}

/// A password out of the environment, where the database's own programs look for it, too: unlike what stands in an address,
/// other users do not see it among the processes.
pub(super) fn password(variable: &str) -> Option<String> {
    std::env::var(variable).ok().filter(|word| !word.is_empty())
}

/// This computer: by a name or an address that does not leave it, or by a socket's path.
fn is_here(host: &str) -> bool {
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    host.is_empty()
        || host.starts_with('/')
        || bare.eq_ignore_ascii_case("localhost")
        || bare.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

/// `%40` is `@`, as in any address; what is no such number stays.
fn decoded(text: &str) -> String {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        let hex = tail
            .get(..2)
            .filter(|_| *first == b'%')
            .and_then(|two| std::str::from_utf8(two).ok())
            .and_then(|two| u8::from_str_radix(two, 16).ok());
        if let Some(byte) = hex {
            bytes.push(byte);
            rest = &tail[2..];
        } else {
            bytes.push(*first);
            rest = tail;
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod way_tests;
