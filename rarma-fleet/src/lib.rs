//! Many machines over months.
//!
//! | module | what |
//! |---|---|
//! | [`record`] | what a box, a test or a person says of a machine, as it is sent and kept |
//! | [`convert`] | what the other commands print, as records |
//! | [`store`] | records in SQLite, PostgreSQL or ClickHouse, and what may be asked of them |
//! | [`trends`] | what has changed beyond its uncertainty, and where it goes |
//! | [`plant`] | machines over months with the truth, to try it on |
//! | [`gateway`] | from boxes to a broker, and what comes back |
//!
//! Data flows one way: record → store → trends. The gateway makes records, and knows neither
//! store nor trends. [docs/plant.md](../../docs/plant.md)

pub mod convert;
pub mod gateway;
pub mod plant;
pub mod record;
pub mod store;
mod tls;
pub mod trends;
