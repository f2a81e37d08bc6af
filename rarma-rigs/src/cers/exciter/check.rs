//! Whether a job is within reach, and the signal of one that is.

use super::job::{ExcitationJob, JobField, OutOfReach, Reach};
use super::source::Source;

impl ExcitationJob {
    /// The signal of the job.
    ///
    /// # Errors
    /// Why it does not go; fields first, then what the magnets and the supply can do.
    pub fn check(&self, reach: &Reach) -> Result<Source, OutOfReach> {
        if !(self.rms_a > 0.0 && self.rms_a <= 10.0) {
            return Err(OutOfReach::Field(JobField::Rms));
        }
        if !(self.seconds >= 0.1 && self.seconds <= 3600.0) {
            return Err(OutOfReach::Field(JobField::Seconds));
        }
        let source = Source::new(self, reach.rate_hz, reach.spindle_hz)?;
        if !reach.calibrated {
            return Err(OutOfReach::Uncalibrated);
        }
        reach.bias()?;
        let peak = self.peak_a();
        let allowed = reach.bias_a.min(reach.most_a - reach.bias_a);
        if !(peak <= allowed) {
            return Err(OutOfReach::Current { peak, allowed });
        }
        let there = reach.volts - reach.resistance_ohm * (reach.bias_a + peak);
        let needed = self.volts(reach);
        if !(needed <= there) {
            return Err(OutOfReach::Voltage { needed, there });
        }
        Ok(source)
    }
}
