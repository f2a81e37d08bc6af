//! One file per command.

mod act;
mod advise;
mod band;
mod cers;
mod channels;
mod choose_order;
mod connect;
mod convert;
mod decode;
mod demo;
mod els;
mod estimators;
mod feed;
mod fitting;
#[cfg(all(feature = "fleet", not(target_family = "wasm")))]
mod fleet;
#[cfg(all(feature = "fleet", not(target_family = "wasm")))]
mod gateway;
mod identify;
mod known;
mod ldbb;
mod listen;
mod listening;
mod lobes;
mod manual;
mod model_pictures;
mod monitor;
mod order;
mod pair;
mod population;
mod process;
mod psd;
mod sensor_box;
mod several;
mod show;
mod simulate;
mod source;
mod sweep;
mod tacho;
mod talk;
#[cfg(all(feature = "emulated-chip", not(target_family = "wasm")))]
mod target;
mod watched;

pub use channels::{
    ChannelModeRecord, ChannelModel, ChannelPole, Channels, ShapeRecord, identify_channels,
};
pub use estimators::{IdentifiedMode, modes_of};
pub use feed::{Feed, Said};
pub use identify::{Identified, identify, identify_recording};
pub use listening::listen_pair;
pub use lobes::{LobePoint, Lobes, chart as lobe_chart, point as lobe_point};
pub use monitor::{job, listen, listen_with_tacho};
pub use order::{Candidate, CandidateMode, Choice, Cluster, order_recording};
pub use psd::{Density, psd_recording};
pub use simulate::{Simulated, simulate};
pub use source::About;
#[cfg(all(feature = "emulated-chip", not(target_family = "wasm")))]
pub use target::on_chip;

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::output;

/// Runs the command; the exit code where it succeeds.
///
/// # Errors
/// See [`Failure`].
pub fn run(cli: &Cli) -> Result<u8, Failure> {
    if cli.quiet {
        output::be_quiet();
    }
    output::check(&cli.command.files())?;
    match &cli.command {
        Command::Monitor(args) if args.more.is_empty() => monitor::main(args),
        Command::Monitor(args) => several::main(args),
        Command::Listen(args) => listen::main(args),
        Command::Advise(args) => advise::main(args),
        Command::Act(args) => act::main(args),
        #[cfg(all(feature = "emulated-chip", not(target_family = "wasm")))]
        Command::Target(args) => target::main(args),
        #[cfg(not(all(feature = "emulated-chip", not(target_family = "wasm"))))]
        Command::Target(_) => Err(Failure::System(
            "target: this program was built without the emulated chip (build it without --no-default-features)".to_owned(),
        )),
        Command::Identify(args) => identify::main(args),
        Command::Order(args) => order::main(args),
        Command::Psd(args) => psd::main(args),
        Command::Convert(args) => convert::main(args),
        Command::Lobes(args) => lobes::main(args),
        Command::Simulate(args) => simulate::main(args),
        Command::ChooseOrder(args) => choose_order::main(args),
        Command::Sweep(args) => sweep::main(args),
        Command::Population(args) => population::main(args),
        Command::Els(command) => els::main(command),
        Command::Ldbb(command) => ldbb::main(command),
        Command::Cers(command) => cers::main(command),
        Command::Box(args) => sensor_box::main(args),
        Command::Decode(args) => decode::main(args),
        Command::Connect(args) => connect::main(args),
        #[cfg(all(feature = "fleet", not(target_family = "wasm")))]
        Command::Store(command) => fleet::store(command),
        #[cfg(all(feature = "fleet", not(target_family = "wasm")))]
        Command::Trends(args) => fleet::trends(args),
        #[cfg(all(feature = "fleet", not(target_family = "wasm")))]
        Command::Plant(args) => fleet::plant(args),
        #[cfg(all(feature = "fleet", not(target_family = "wasm")))]
        Command::Gateway(args) => gateway::main(args),
        #[cfg(not(all(feature = "fleet", not(target_family = "wasm"))))]
        Command::Store(_) | Command::Trends(_) | Command::Plant(_) | Command::Gateway(_) => Err(Failure::System(
            "store, trends, plant, gateway: this program was built without them (build it with `--features fleet`)"
                .to_owned(),
        )),
        Command::Demo(args) => demo::main(args),
        Command::Completions(args) => manual::completions(args),
        Command::Man(args) => manual::man(args),
    }
}
