//! A store in ClickHouse, over its HTTP interface.

use super::backend::{Backend, Rows, StoreError, Value, spelled};
use super::tables::{Dialect, Table};
use super::way::{self, Way};
use crate::tls::{certificates, provider};
use std::sync::Arc;
use std::time::Duration;
use ureq::tls::{Certificate, RootCerts, TlsConfig};

/// Largest answer that is taken, bytes.
const MOST_ANSWER: u64 = 4 << 30;

/// A database.
pub struct ClickHouse {
    agent: ureq::Agent,
    url: String,
    database: String,
    login: Option<(String, String)>,
    way: Way,
}

impl ClickHouse {
    /// Of `USER:PASSWORD@HOST:PORT/DATABASE`; user and password, port (8123; 8443 with TLS) and database (`default`)
    /// may be left out.
    ///
    /// # Errors
    /// Nobody answers, or not safely.
    pub fn open(place: &str) -> Result<Self, StoreError> {
        let (place, way) = way::taken_from(place)?;
        let (login, rest) = match place.rsplit_once('@') {
            Some((login, rest)) => {
                let (user, password) = match login.split_once(':') {
                    Some((user, password)) => (user, password.to_owned()),
                    None => (
                        login,
                        way::password("CLICKHOUSE_PASSWORD").unwrap_or_default(),
                    ),
                };
                (Some((user.to_owned(), password)), rest)
            }
            None => (None, place.as_str()),
        };
        let (host, database) = rest.split_once('/').unwrap_or((rest, "default"));
        let named = !database.is_empty()
            && database
                .bytes()
                .all(|b| b.is_ascii_alphanumeric() || b == b'_');
        if !named {
            return Err(StoreError::Database(
                "the name of the database has other than letters, digits and _".to_owned(),
            ));
        }
        let (bare, port) = match host.rsplit_once(':') {
            // The colons of an address in brackets are no port's.
            Some((bare, port)) if !port.contains(']') => (bare, Some(port)),
            _ => (host, None),
        };
        way.allows(bare)?;
        let mut config = ureq::Agent::config_builder()
            .timeout_global(Some(Duration::from_secs(120)))
            .http_status_as_error(false);
        let (scheme, usual) = if let Way::Tls(root) = &way {
            let roots = certificates(root).map_err(StoreError::Way)?;
            let roots = roots
                .iter()
                .map(|one| Certificate::from_der(one).to_owned());
            let tls = TlsConfig::builder()
                .root_certs(RootCerts::Specific(Arc::new(roots.collect())))
                .unversioned_rustls_crypto_provider(provider())
                .build();
            // Nothing leads back to where it is in clear.
            config = config.tls_config(tls).https_only(true);
            ("https", "8443")
        } else {
            ("http", "8123")
        };
        let mut opened = Self {
            agent: config.build().into(),
            url: format!("{scheme}://{bare}:{}/", port.unwrap_or(usual)),
            database: database.to_owned(),
            login,
            way,
        };
        opened.execute("SELECT 1")?;
        Ok(opened)
    }

    /// Sends a statement, with data behind it.
    fn send(&self, sql: &str, parameters: &[Value], data: &str) -> Result<String, StoreError> {
        let mut request = self
            .agent
            .post(&self.url)
            .query("database", &self.database)
            // Whole numbers without quotes; as many digits as bring a float back.
            .query("output_format_json_quote_64bit_integers", "0")
            .query("query", sql);
        if let Some((user, password)) = &self.login {
            request = request
                .header("X-ClickHouse-User", user)
                .header("X-ClickHouse-Key", password);
        }
        for (n, value) in (1..).zip(parameters) {
            let text = match value {
                Value::Null => String::new(),
                Value::Int(n) => n.to_string(),
                Value::Real(x) => x.to_string(),
                // The interface reads a parameter as a field of a table: \ and tab are escaped there.
                Value::Text(t) => t
                    .replace('\\', "\\\\")
                    .replace('\t', "\\t")
                    .replace('\n', "\\n"),
            };
            request = request.query(format!("param_p{n}"), &text);
        }
        let failed = |e: ureq::Error| {
            let said = e.to_string();
            StoreError::Database(format!("ClickHouse: {said}{}", self.way.doubt(&said)))
        };
        let mut response = request.send(data).map_err(failed)?;
        let good = response.status().is_success();
        let body = response
            .body_mut()
            .with_config()
            .limit(MOST_ANSWER)
            .read_to_string()
            .map_err(failed)?;
        if good {
            Ok(body)
        } else {
            let line = body.lines().next().unwrap_or("no reason").to_owned();
            Err(StoreError::Database(format!("ClickHouse: {line}")))
        }
    }
}

impl Backend for ClickHouse {
    fn dialect(&self) -> Dialect {
        Dialect::ClickHouse
    }

    fn execute(&mut self, sql: &str) -> Result<(), StoreError> {
        self.send(sql, &[], "").map(drop)
    }

    fn execute_all(&mut self, statements: &[String]) -> Result<(), StoreError> {
        statements.iter().try_for_each(|sql| self.execute(sql))
    }

    fn query(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError> {
        let sql = spelled(Dialect::ClickHouse, sql, parameters);
        let answer = self.send(&format!("{sql} FORMAT JSONCompactEachRow"), parameters, "")?;
        answer
            .lines()
            .filter(|line| !line.is_empty())
            .map(row)
            .collect()
    }

    fn insert(&mut self, rows: &[(&'static Table, Rows)]) -> Result<(), StoreError> {
        for (table, rows) in rows {
            if rows.is_empty() {
                continue;
            }
            let mut data = String::new();
            for row in rows {
                let row: Vec<serde_json::Value> = row.iter().map(json).collect();
                data.push_str(&serde_json::Value::Array(row).to_string());
                data.push('\n');
            }
            self.send(
                &format!("INSERT INTO {} FORMAT JSONCompactEachRow", table.name),
                &[],
                &data,
            )?;
        }
        Ok(())
    }

    fn put_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError> {
        // The row of the same key that comes later takes the place of the one before.
        let row = serde_json::json!([name, value]).to_string();
        self.send("INSERT INTO meta FORMAT JSONCompactEachRow", &[], &row)
            .map(drop)
    }
}

fn json(value: &Value) -> serde_json::Value {
    match value {
        Value::Null => serde_json::Value::Null,
        Value::Int(n) => (*n).into(),
        Value::Real(x) => (*x).into(),
        Value::Text(t) => t.as_str().into(),
    }
}

fn row(line: &str) -> Result<Vec<Value>, StoreError> {
    let values: Vec<serde_json::Value> =
        serde_json::from_str(line).map_err(|e| StoreError::Answer(e.to_string()))?;
    values
        .into_iter()
        .map(|value| match value {
            serde_json::Value::Null => Ok(Value::Null),
            serde_json::Value::String(text) => Ok(Value::Text(text)),
            serde_json::Value::Number(n) => n
                .as_i64()
                .map(Value::Int)
                .or_else(|| n.as_f64().map(Value::Real))
                .ok_or_else(|| StoreError::Answer(n.to_string())),
            other => Err(StoreError::Answer(other.to_string())),
        })
        .collect()
}
