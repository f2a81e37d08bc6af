//! What the page draws, and what its report is made of.

use crate::settings::Settings;
use crate::spectrum::Spectrum;
use crate::view::Point;
use rarma_cli::collect::News;
use rarma_cli::report::{Course, Sound};
use rarma_cli::sound_card::Level;

/// Of so many lines one is drawn: 20 a second.
const EVERY_LINE: u64 = 5;
/// Points that wait to be fetched, at most; older ones go.
const MOST_POINTS: usize = 4096;
/// The level is that of so long, s.
const LEVEL_S: f64 = 1.0;

/// Pictures as they grow.
#[derive(Debug, Clone)]
pub(crate) struct Pictures {
    pub(crate) sound: Sound,
    pub(crate) course: Course,
    pub(crate) spectrum: Spectrum,
    pub(crate) level: Option<Level>,
    second: Vec<f32>,
    second_full: usize,
    points: Vec<Point>,
    lines: u64,
}

impl Pictures {
    pub(crate) fn new(settings: &Settings) -> Self {
        let band_hz = settings.band_hz();
        Self {
            sound: Sound::new(settings.fs, band_hz),
            course: Course::default(),
            spectrum: Spectrum::new(settings.fs, band_hz.1),
            level: None,
            second: Vec::new(),
            second_full: (LEVEL_S * settings.fs) as usize,
            points: Vec::new(),
            lines: 0,
        }
    }

    /// A sample was heard.
    pub(crate) fn sample(&mut self, x: f32) {
        self.sound.push(f64::from(x));
        self.spectrum.push(x);
        self.second.push(x);
        if self.second.len() >= self.second_full {
            self.level = Some(Level::of(&self.second));
            self.second.clear();
        }
    }

    /// So many are missing: silence in the pictures, and no part of the level.
    pub(crate) fn missing(&mut self, n: u64) {
        for _ in 0..n {
            self.sound.push(0.0);
            self.spectrum.push(0.0);
        }
    }

    pub(crate) fn take(&mut self, news: &News) {
        self.course.take(news);
        let News::Line(line) = news else {
            return;
        };
        self.lines += 1;
        if !self.lines.is_multiple_of(EVERY_LINE) {
            return;
        }
        if self.points.len() >= MOST_POINTS {
            self.points.drain(..MOST_POINTS / 2);
        }
        self.points.push(Point {
            t: line.t,
            modes: line.modes.clone(),
            state: line.state,
        });
    }

    /// The points since the last time.
    pub(crate) fn points(&mut self) -> Vec<Point> {
        std::mem::take(&mut self.points)
    }
}
