//! `rarma demo`: the virtual machine tool cuts into chatter, and the firmware
//! application hears it through the simulated hardware.

use super::show;
use crate::args::DemoArgs;
use crate::collect::{Collector, News};
use crate::failure::Failure;
use crate::output;
use crate::report::{self, Course, Provenance, ReportInput, Sound};
use firmware::Job;
use hal_sim::{Microphone, SimBoard};
use rarma_box::wire::{Deframer, MonitorJob, Telemetry};
use rarma_core::monitor::MonitorConfig;
use rarma_core::named::Named;
use rarma_plants::cut::VirtualCut;
use rarma_plants::truth::Truth;
use rarma_scenarios::scenario;
use std::cell::RefCell;
use std::rc::Rc;

/// The shipped scenario that is played.
const SCENARIO: &str = "chatter-onset";
/// The demonstration's lines come this often, s.
const EVERY_S: f64 = 0.01;

pub(super) fn main(args: &DemoArgs) -> Result<u8, Failure> {
    let scenario = scenario::load(SCENARIO, Some(args.seed))?.scenario;
    let name = scenario.name.clone();
    let broken = |why| Failure::System(format!("scenario {name}: {why}"));
    let truth = scenario.truth().map_err(broken)?;
    let cut = VirtualCut::new(&scenario).map_err(broken)?;
    let (fs, length) = (cut.sample_rate_hz(), cut.len() as u64);
    describe(&name, &truth, length as f64 / fs);

    // What the microphone hears is kept for the page's pictures.
    let band = MonitorConfig::new(fs).band();
    let band_hz = (band.low_hz, band.high_hz);
    let heard = Rc::new(RefCell::new(Sound::new(fs, band_hz)));
    let ear = Rc::clone(&heard);
    let signal = cut.map(move |reading| {
        ear.borrow_mut().push(f64::from(reading.value));
        reading.value
    });
    let mut board = SimBoard::new(Microphone::hearing(signal, fs));
    let job = MonitorJob {
        monitor: MonitorConfig {
            full_scale: Some(1.0),
            spindle_hz: Some(truth.spindle_hz),
            teeth: u32::try_from(truth.teeth).ok(),
            ..MonitorConfig::new(fs)
        },
        channel: 0,
        every_s: EVERY_S,
    };
    let mut course = Course::default();
    let (collector, frames) = play(&mut board, &job, length, &heard, &mut course)?;
    output::write_all(&args.out, [("telemetry.bin".to_owned(), frames)])?;
    let summary = collector
        .summary()
        .ok_or_else(|| Failure::System("the box ended without its last frame".to_owned()))?;

    say!("");
    show::verdict(&summary);
    if let (Some(onset), Some(alarm)) = (truth.onset_s, summary.alarms.first()) {
        let ms = 1e3 * (alarm.on - onset);
        say!(
            "The depth passed the stability limit at {onset:.3} s: called {:.0} ms {} that.",
            ms.abs(),
            if ms < 0.0 { "before" } else { "after" }
        );
    }
    let page = report::write(
        &args.out,
        &ReportInput {
            title: "Demonstration: a simulated cut into chatter",
            source_name: &name,
            sound: &heard.borrow(),
            fs,
            course: &course,
            summary: &summary,
            threshold: job.monitor.threshold,
            band_hz,
            rpm: Some(60.0 * truth.spindle_hz),
            teeth: job.monitor.teeth,
            truth_onset_s: truth.onset_s,
            truth_note: Some("virtual machine tool: depth passes the stability limit".to_owned()),
            missing: None,
            window_s: None,
            provenance: &Provenance::of_this_run(),
            version: env!("CARGO_PKG_VERSION"),
        },
    )?;
    say!("Report: {}", page.display());
    if summary.alarms.is_empty() {
        return Err(Failure::System(
            "the simulated chatter was not called: a defect of this program".to_owned(),
        ));
    }
    Ok(0)
}

fn describe(name: &str, truth: &Truth, seconds: f64) {
    say!(
        "Scenario {name}: {seconds:.1} s of milling, played to the firmware through a simulated board."
    );
    say!(
        "  spindle {:.0} 1/min, {} teeth (tooth passing {:.1} Hz)",
        60.0 * truth.spindle_hz,
        truth.teeth,
        truth.tooth_hz
    );
    if let (Some(limit), Some(onset)) = (truth.limit_depth_m(), truth.onset_s) {
        say!(
            "  the depth passes the stability limit of {:.2} mm at {onset:.2} s",
            1e3 * limit
        );
    }
    say!("");
}

/// Runs the job to the end of the cut, decoding its frames as they come.
fn play(
    board: &mut SimBoard,
    job: &MonitorJob,
    length: u64,
    heard: &Rc<RefCell<Sound>>,
    course: &mut Course,
) -> Result<(Collector, Vec<u8>), Failure> {
    let bar = show::progress(length, "cutting");
    let mut collector = Collector::default();
    let mut deframer = Deframer::default();
    let mut frames = Vec::new();
    let mut running = Job::start(board, job)
        .map_err(|why| Failure::System(format!("the box refused the job: {why:?}")))?;
    let mut state = None;
    loop {
        let outcome = running.step();
        let bytes = running.board().link.take();
        for &byte in &bytes {
            let Some(frame) = deframer.push::<Telemetry>(byte) else {
                continue;
            };
            let (_, message) =
                frame.map_err(|why| Failure::System(format!("a frame is broken: {why:?}")))?;
            let news = collector.take(&message);
            show::alarm(&news, &bar);
            course.take(&news);
            if let News::Line(line) = news
                && state != Some(line.state)
            {
                state = Some(line.state);
                let text = format!("{:8.3} s  {}", line.t, line.state.name());
                bar.suspend(|| say!("{text}"));
            }
        }
        frames.extend(bytes);
        bar.set_position(heard.borrow().samples());
        if outcome.is_some() {
            bar.finish_and_clear();
            return Ok((collector, frames));
        }
    }
}
