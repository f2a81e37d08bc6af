//! Options of `advise` and `act`: the machine, where it is known.

use super::within;
use clap::Args;

/// The machine that is told.
#[derive(Debug, Clone, Default, Args)]
pub struct MachineArgs {
    /// The machine and this cut, as `rarma lobes` reads them (a scenario's file, or a shipped one): modes with
    /// stiffness and direction, cutter, arc, cutting coefficients, depth. All modes count then.
    #[arg(long, value_name = "SCENARIO")]
    pub machine: Option<String>,
    /// How far what that file says may be off, over what is usual after a hammer test: frequencies 0.3 %,
    /// damping 10 %, stiffnesses 5 %, directions 3°, cutting coefficients 10 % [default: 1].
    #[arg(long, value_name = "FACTOR", requires = "machine", value_parser = |text: &str| within(text, 0.1, 10.0))]
    pub machine_sd: Option<f64>,
}
