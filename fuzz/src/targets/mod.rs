//! The targets, by what they read.

mod box_side;
mod link;
mod measurement;
mod plant;
mod recording;
mod scenario;
mod speeds;
mod words;

use crate::Target;

pub(crate) const ALL: [Target; 21] = [
    recording::WAV,
    recording::TABLE,
    recording::RAW,
    recording::TDMS,
    recording::FRAMES,
    speeds::SPEEDS,
    measurement::RECEPTANCES,
    measurement::UNIVERSAL,
    measurement::CIRCLES,
    measurement::LOAD_STEPS,
    measurement::STRUCTURE,
    scenario::CUT,
    scenario::BOX,
    scenario::RIGS,
    scenario::EXCITER_RECORD,
    link::FRAMES,
    box_side::COMMANDS,
    box_side::STORE,
    words::WORDS,
    plant::RECORDS,
    plant::SPARKPLUG,
];
