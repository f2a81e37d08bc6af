//! TLS to the broker.

use super::config::Broker;
use crate::tls::{certificates, said, trusting};
use rumqttc::{TlsConfiguration, Transport};
use std::sync::Arc;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;
use tokio_rustls::rustls::pki_types::pem::PemObject as _;

/// How the broker is reached.
///
/// # Errors
/// A file cannot be read, or holds none of what it should; in one line.
pub(super) fn transport(broker: &Broker) -> Result<Transport, String> {
    let Some(ca) = &broker.ca else {
        return Ok(Transport::Tcp);
    };
    let builder = trusting(ca)?;
    let config = match (&broker.certificate, &broker.certificate_key) {
        (Some(own), Some(key)) => {
            let read =
                PrivateKeyDer::from_pem_file(key).map_err(|why| said(key, &why.to_string()))?;
            builder
                .with_client_auth_cert(certificates(own)?, read)
                .map_err(|why| said(own, &why.to_string()))?
        }
        _ => builder.with_no_client_auth(),
    };
    Ok(Transport::Tls(TlsConfiguration::Rustls(Arc::new(config))))
}
