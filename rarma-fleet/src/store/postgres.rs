//! A store in PostgreSQL.

use super::backend::{Backend, Rows, StoreError, Value, spelled};
use super::sums;
use super::tables::{Dialect, Table, Type as Kind};
use super::way::{self, Way};
use crate::tls::trusting;
use ::postgres::config::{Host, SslMode};
use ::postgres::types::{FromSql, IsNull, ToSql, Type};
use ::postgres::{Client, Config, NoTls};
use std::error::Error;
use std::time::Duration;
use tokio_postgres_rustls::MakeRustlsConnect;

/// A server that does not answer is given up after so long.
const WAIT: Duration = Duration::from_secs(30);

/// Rows in one statement.
const BLOCK: usize = 1000;

/// Writers take turns: each adds to the same rows of `sums`, and two that did so in another order would wait for
/// each other. The number is ours ("rarm").
const WRITING: &str = "SELECT pg_advisory_xact_lock(1918989933)";

/// A database.
pub struct Postgres {
    config: Config,
    way: Way,
    client: Client,
}

impl From<::postgres::Error> for StoreError {
    fn from(error: ::postgres::Error) -> Self {
        // The server's own words; the outer error says only that there was one.
        let said = error
            .source()
            .map_or_else(|| error.to_string(), ToString::to_string);
        Self::Database(format!("PostgreSQL: {said}"))
    }
}

impl Postgres {
    /// Connects.
    ///
    /// # Errors
    /// Nobody answers, or not to this user, or not safely.
    pub fn open(place: &str) -> Result<Self, StoreError> {
        let (address, way) = way::taken_from(place)?;
        let mut config: Config = address.parse()?;
        if config.get_password().is_none()
            && let Some(word) = way::password("PGPASSWORD")
        {
            config.password(word);
        }
        // An address, where there is one, is where it goes; the name is then only what the certificate must have.
        for ip in config.get_hostaddrs() {
            way.allows(&ip.to_string())?;
        }
        if config.get_hostaddrs().is_empty() {
            for host in config.get_hosts() {
                if let Host::Tcp(name) = host {
                    way.allows(name)?;
                }
            }
        }
        let client = connected(&mut config, &way)?;
        Ok(Self {
            config,
            way,
            client,
        })
    }

    /// The connection; a new one where the last has ended: a server that was away is there again.
    fn client(&mut self) -> Result<&mut Client, StoreError> {
        if self.client.is_closed() {
            self.client = connected(&mut self.config, &self.way)?;
        }
        Ok(&mut self.client)
    }
}

fn connected(config: &mut Config, way: &Way) -> Result<Client, StoreError> {
    // A network that is gone says nothing: it is not waited for for ever, unless the address says how long.
    if config.get_connect_timeout().is_none() {
        config.connect_timeout(WAIT);
    }
    if config.get_tcp_user_timeout().is_none() {
        config.tcp_user_timeout(WAIT);
    }
    let connected = if let Way::Tls(root) = way {
        let tls = trusting(root).map_err(StoreError::Way)?;
        config.ssl_mode(SslMode::Require);
        config.connect(MakeRustlsConnect::new(tls.with_no_client_auth()))
    } else {
        config.ssl_mode(SslMode::Disable);
        config.connect(NoTls)
    };
    let mut client = connected.map_err(|why| match StoreError::from(why) {
        StoreError::Database(said) => {
            let doubt = way.doubt(&said);
            StoreError::Database(said + &doubt)
        }
        other => other,
    })?;
    // "relation exists already, skipping" is no news.
    client.batch_execute("SET client_min_messages = warning")?;
    Ok(client)
}

impl ToSql for Value {
    fn to_sql(
        &self,
        kind: &Type,
        out: &mut ::postgres::types::private::BytesMut,
    ) -> Result<IsNull, Box<dyn Error + Sync + Send>> {
        match self {
            Self::Null => Ok(IsNull::Yes),
            Self::Int(n) => n.to_sql(kind, out),
            Self::Real(x) => x.to_sql(kind, out),
            Self::Text(t) => t.to_sql(kind, out),
        }
    }

    fn accepts(kind: &Type) -> bool {
        matches!(*kind, Type::INT8 | Type::FLOAT8 | Type::TEXT)
    }

    ::postgres::types::to_sql_checked!();
}

impl<'a> FromSql<'a> for Value {
    fn from_sql(kind: &Type, raw: &'a [u8]) -> Result<Self, Box<dyn Error + Sync + Send>> {
        Ok(match *kind {
            Type::INT8 => Self::Int(i64::from_sql(kind, raw)?),
            Type::INT4 => Self::Int(i64::from(i32::from_sql(kind, raw)?)),
            Type::FLOAT8 => Self::Real(f64::from_sql(kind, raw)?),
            _ => Self::Text(String::from_sql(kind, raw)?),
        })
    }

    fn from_sql_null(_: &Type) -> Result<Self, Box<dyn Error + Sync + Send>> {
        Ok(Self::Null)
    }

    fn accepts(kind: &Type) -> bool {
        matches!(
            *kind,
            Type::INT8 | Type::INT4 | Type::FLOAT8 | Type::TEXT | Type::VARCHAR
        )
    }
}

impl Backend for Postgres {
    fn dialect(&self) -> Dialect {
        Dialect::Postgres
    }

    fn execute(&mut self, sql: &str) -> Result<(), StoreError> {
        Ok(self.client()?.batch_execute(sql)?)
    }

    fn execute_all(&mut self, statements: &[String]) -> Result<(), StoreError> {
        let mut transaction = self.client()?.transaction()?;
        transaction.batch_execute(WRITING)?;
        for statement in statements {
            transaction.batch_execute(statement)?;
        }
        Ok(transaction.commit()?)
    }

    fn query(&mut self, sql: &str, parameters: &[Value]) -> Result<Rows, StoreError> {
        let sql = spelled(Dialect::Postgres, sql, parameters);
        let parameters: Vec<&(dyn ToSql + Sync)> = parameters.iter().map(|p| p as _).collect();
        let rows = self.client()?.query(&sql, &parameters)?;
        rows.iter()
            .map(|row| (0..row.len()).map(|i| Ok(row.try_get(i)?)).collect())
            .collect()
    }

    fn insert(&mut self, rows: &[(&'static Table, Rows)]) -> Result<(), StoreError> {
        let mut transaction = self.client()?.transaction()?;
        transaction.batch_execute(WRITING)?;
        for (table, rows) in rows {
            // Whole columns as arrays: one short statement whatever the number of rows.
            let arrays: Vec<String> = (table.columns.iter().zip(1..))
                .map(|(column, n)| {
                    let kind = match column.kind {
                        Kind::Text => "TEXT",
                        Kind::Int => "BIGINT",
                        Kind::Real => "DOUBLE PRECISION",
                    };
                    format!("${n}::{kind}[]")
                })
                .collect();
            let mut sql = format!(
                "INSERT INTO {} SELECT * FROM unnest({}) ON CONFLICT DO NOTHING",
                table.name,
                arrays.join(", ")
            );
            if table.summed {
                // Only what was not there is returned, and counted.
                sql = format!(
                    "WITH new AS ({sql} RETURNING machine, kind, month, state, seconds, time_us) \
                     INSERT INTO sums {} {}",
                    sums::select("new", "TRUE"),
                    sums::ADD
                );
            }
            let statement = transaction.prepare(&sql)?;
            for block in rows.chunks(BLOCK) {
                let columns: Vec<Vec<&Value>> = (0..table.columns.len())
                    .map(|c| block.iter().map(|row| &row[c]).collect())
                    .collect();
                let parameters: Vec<&(dyn ToSql + Sync)> = columns.iter().map(|c| c as _).collect();
                transaction.execute(&statement, &parameters)?;
            }
        }
        Ok(transaction.commit()?)
    }

    fn put_meta(&mut self, name: &str, value: i64) -> Result<(), StoreError> {
        self.client()?.execute(
            "INSERT INTO meta VALUES ($1, $2) ON CONFLICT (name) DO UPDATE SET value = excluded.value",
            &[&name, &value],
        )?;
        Ok(())
    }
}
