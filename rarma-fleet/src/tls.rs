//! TLS with the plant's own certificates and no others: to the broker, and to databases.

use std::path::Path;
use std::sync::Arc;
use tokio_rustls::rustls::client::WantsClientCert;
use tokio_rustls::rustls::crypto::{CryptoProvider, ring};
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;
use tokio_rustls::rustls::{ClientConfig, ConfigBuilder, RootCertStore};

/// Whose arithmetic is used.
pub(crate) fn provider() -> Arc<CryptoProvider> {
    Arc::new(ring::default_provider())
}

/// A client that takes nobody but whom one of these certificates has signed, under the name it was asked for.
///
/// # Errors
/// The file cannot be read, or holds no certificate; in one line.
pub(crate) fn trusting(ca: &Path) -> Result<ConfigBuilder<ClientConfig, WantsClientCert>, String> {
    let mut roots = RootCertStore::empty();
    for one in certificates(ca)? {
        roots.add(one).map_err(|why| said(ca, &why.to_string()))?;
    }
    Ok(ClientConfig::builder_with_provider(provider())
        .with_safe_default_protocol_versions()
        .map_err(|why| said(ca, &why.to_string()))?
        .with_root_certificates(roots))
}

/// The certificates of a file, one at least.
///
/// # Errors
/// It cannot be read, or holds none.
pub(crate) fn certificates(path: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let read = CertificateDer::pem_file_iter(path).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    match read {
        Ok(found) if found.is_empty() => Err(said(path, "no certificate in it")),
        Ok(found) => Ok(found),
        Err(why) => Err(said(path, &why.to_string())),
    }
}

/// What is wrong with a file, in one line.
pub(crate) fn said(path: &Path, what: &str) -> String {
    format!(
        "{}: {what} (a file in PEM is needed, as openssl writes it)",
        path.display()
    )
    .replace('\n', " ")
}
