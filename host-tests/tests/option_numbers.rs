//! Promise: whatever number stands behind an option, the command ends, well or with one
//! line of refusal, in bounded time and memory.

use host_tests::files::Folder;
use host_tests::hard::{Bounds, Verdict, bounded};
use host_tests::piped::Workday;
use host_tests::rarma;
use rayon::prelude::*;

const ODD: [&str; 11] = [
    "0",
    "-1",
    "1e-308",
    "1e308",
    "nan",
    "inf",
    "9223372036854775807",
    "-9223372036854775808",
    "0.5",
    "1e6",
    "1000000",
];

/// `{}` stands for the number, `FILE` for a recording of two channels, `RAW` for a raw one.
const OPTIONS: [&str; 37] = [
    "advise FILE --json --rpm={} --teeth=4",
    "advise FILE --json --rpm=6000 --teeth={}",
    "advise FILE --json --rpm=6000 --teeth=4 --reach={}:120",
    "advise FILE --json --rpm=6000 --teeth=4 --reach=50:{}",
    "advise FILE --json --rpm=6000 --teeth=4 --power={}",
    "advise FILE --json --rpm=6000 --teeth=4 --depth-mm={}",
    "advise FILE --json --rpm=11000 --teeth=3 --machine=three-mode-chatter --machine-sd={}",
    "monitor FILE --json --rpm={}",
    "monitor FILE --json --rpm=6000 --teeth={}",
    "monitor FILE --json --threshold={}",
    "monitor FILE --json --every={}",
    "monitor FILE --json --fs={}",
    "monitor FILE --json --channel={}",
    "monitor FILE --json --second={}",
    "monitor FILE --json --tacho={}",
    "monitor FILE --json --tacho=1 --pulses={}",
    "monitor FILE --json --band={}:2000",
    "monitor FILE --json --band=300:{}",
    "monitor FILE --json --idle={}:3",
    "monitor FILE --json --idle=0:{}",
    "monitor FILE --json --order={},1",
    "monitor RAW --raw=s16 --json --fs={}",
    "sweep two-tooth-benchmark --json --depth-mm=0.1:0.2 --steps=1 --seconds=0.5 --rpm={}",
    "sweep two-tooth-benchmark --json --depth-mm={}:0.2 --steps=1 --seconds=0.5",
    "sweep two-tooth-benchmark --json --depth-mm=0.1:{} --steps=1 --seconds=0.5",
    "sweep two-tooth-benchmark --json --depth-mm=0.1:0.2 --seconds=0.5 --steps={}",
    "sweep two-tooth-benchmark --json --depth-mm=0.1:0.2 --steps=1 --seconds={}",
    "lobes two-tooth-benchmark --json --speeds=1 --rpm={}:10000",
    "lobes two-tooth-benchmark --json --speeds=1 --rpm=10000:{}",
    "lobes two-tooth-benchmark --json --speeds=1 --max-depth-mm={}",
    "lobes two-tooth-benchmark --json --speeds={}",
    "els model els-holder --json --load={}",
    "simulate two-tooth-benchmark --json --seed={}",
    "ldbb run ldbb-m3 --json --bar-compliance={}",
    "ldbb run ldbb-m3 --json --force-sd={}",
    "ldbb run ldbb-m3 --json --pitch={}",
    "ldbb run ldbb-m3 --json --tolerance={}",
];

#[test]
fn every_number_behind_an_option_is_used_or_refused() {
    let folder = Folder::default();
    let samples: Vec<i16> = Workday::new(8_000.0).take(4 * 8_000).collect();
    let both: Vec<u8> = samples
        .iter()
        .flat_map(|x| [*x, x / 2])
        .flat_map(i16::to_le_bytes)
        .collect();
    let file = folder.file(
        "two.wav",
        &host_tests::files::wav(host_tests::files::PCM, 2, 8_000, 16, &both),
    );
    let raw = folder.file("one.raw", &both);
    let cases: Vec<String> = OPTIONS
        .iter()
        .flat_map(|option| ODD.map(|odd| option.replace("{}", odd)))
        .map(|words| {
            let words = words.replace("FILE", file.to_str().expect("UTF-8"));
            words.replace("RAW", raw.to_str().expect("UTF-8"))
        })
        .collect();
    let bad: Vec<String> = cases
        .par_iter()
        .filter_map(
            |words| match bounded(rarma!(), words.split(' '), Bounds::default()) {
                Verdict::Well => None,
                Verdict::Bad(why) => Some(format!("{words}: {why}")),
            },
        )
        .collect();
    assert!(
        bad.is_empty(),
        "{} of {}:\n{}",
        bad.len(),
        cases.len(),
        bad.join("\n")
    );
}
