//! The strongest line of a sound.

use core::f64::consts::TAU;

/// Length of a look, s.
const WINDOW_S: f64 = 0.2;

/// Lowest and highest frequency, Hz, that the strongest line has within these times, s.
pub(super) fn range_hz(sound: &[f64], fs_hz: f64, times_s: &[(f64, f64)]) -> Option<(f64, f64)> {
    let window = ((WINDOW_S * fs_hz) as usize).max(16);
    let n = (2 * window).next_power_of_two();
    let transform = rarma_fourier::forward(n);
    let mut lines = transform.make_output_vec();
    let mut input = transform.make_input_vec();
    let mut out: Option<(f64, f64)> = None;
    for (from, to) in times_s {
        let last = ((to * fs_hz) as usize).min(sound.len());
        let mut begin = (from * fs_hz) as usize;
        while let Some(part) = sound.get(begin..begin + window)
            && begin + window <= last
        {
            input.fill(0.0);
            for (k, (to, x)) in input.iter_mut().zip(part).enumerate() {
                let turn = TAU * k as f64 / window as f64;
                *to = 0.5 * (1.0 - turn.cos()) * x;
            }
            if transform.process(&mut input, &mut lines).is_err() {
                break;
            }
            let strongest = (0..lines.len())
                .max_by(|a, b| lines[*a].norm_sqr().total_cmp(&lines[*b].norm_sqr()));
            let f_hz = strongest.unwrap_or(0) as f64 * fs_hz / n as f64;
            out = Some(out.map_or((f_hz, f_hz), |(low, high)| (low.min(f_hz), high.max(f_hz))));
            begin += window;
        }
    }
    out
}
