//! The fit behind `--channels`, and which modes stay from order to order.

use super::Job;
use super::record::{ChannelModeRecord, ChannelModel, ChannelPole, Channels, ShapeRecord};
use crate::commands::band::{self, Part};
use rarma_core::spectrum::Modal;
use rarma_fit::{
    ChannelError, ChannelMode, StabilisationConfig, Stability, Subspace, SubspaceConfig, mac,
    stabilise,
};

/// Least likeness of two shapes that are the same.
const SAME_SHAPE: f64 = 0.95;

/// Fits all orders up to the one asked for.
pub(super) fn fit(parts: &[Part], channels: &[usize], job: &Job) -> Result<Channels, String> {
    let part = parts.first().ok_or("no channel")?;
    let config = SubspaceConfig {
        rows: job.rows,
        stretches: job.stretches,
        most_order: job.order,
        ..SubspaceConfig::default()
    };
    let series: Vec<&[f64]> = parts.iter().map(|part| &part.samples[..]).collect();
    let subspace = Subspace::of(&series, &job.references, config).map_err(|why| why.to_string())?;
    let (low, high) = part.edges();
    let at = |order: usize| -> Result<Vec<ChannelMode>, ChannelError> {
        let mut modes = subspace.modes(order, part.fs)?;
        modes.retain(|m| (low..=high).contains(&m.frequency));
        Ok(modes)
    };
    let mut below: Vec<ChannelMode> = Vec::new();
    let mut orders = Vec::new();
    // The order that was asked for, and those of whole modes below it.
    for order in (2..job.order).step_by(2) {
        // One that the record does not hold is left out.
        let modes = at(order).unwrap_or_default();
        orders.push(ChannelModel {
            order,
            modes: poles(&below, &modes),
        });
        below = modes;
    }
    let modes = at(job.order).map_err(|why| why.to_string())?;
    let poles = poles(&below, &modes);
    orders.push(ChannelModel {
        order: job.order,
        modes: poles.clone(),
    });
    Ok(Channels {
        method: "ssi-cov",
        order: job.order,
        channels: channels.to_vec(),
        references: job.references.iter().map(|k| channels[*k]).collect(),
        rows: job.rows,
        stretches: job.stretches,
        band: band::in_json(part.band),
        fs: part.fs,
        n: part.samples.len(),
        modes: poles
            .into_iter()
            .zip(&modes)
            .map(|(pole, mode)| ChannelModeRecord {
                pole,
                shape: shape(mode, channels),
            })
            .collect(),
        orders,
        singular_values: subspace.singular_values().to_vec(),
    })
}

fn shape(mode: &ChannelMode, channels: &[usize]) -> Vec<ShapeRecord> {
    channels
        .iter()
        .zip(&mode.shape)
        .map(|(channel, part)| ShapeRecord {
            channel: *channel,
            re: part.re,
            im: part.im,
            magnitude: part.magnitude(),
            magnitude_sd: part.magnitude_sd,
            phase_deg: part.phase().to_degrees(),
            phase_deg_sd: part.phase_sd.to_degrees(),
        })
        .collect()
}

/// The modes of an order against those of the order below.
fn poles(below: &[ChannelMode], modes: &[ChannelMode]) -> Vec<ChannelPole> {
    let modal = |modes: &[ChannelMode]| -> Vec<Modal<f64>> {
        let of = |m: &ChannelMode| Modal {
            frequency: m.frequency,
            damping: m.damping,
        };
        modes.iter().map(of).collect()
    };
    let mut marks = vec![Stability::New; modes.len()];
    // More modes than it compares stay unmarked.
    let _ = stabilise(
        &StabilisationConfig::default(),
        &modal(below),
        &modal(modes),
        &mut marks,
    );
    modes
        .iter()
        .zip(marks)
        .map(|(mode, mark)| {
            let off = |other: &&ChannelMode| (other.frequency - mode.frequency).abs();
            let nearest = below.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let alike = nearest
                .map(|other| mac(&other.pairs(), &mode.pairs()))
                .filter(|mac| mac.is_finite());
            ChannelPole {
                f: mode.frequency,
                f_sd: mode.frequency_sd,
                zeta: mode.damping,
                zeta_sd: mode.damping_sd,
                stable_f: mark != Stability::New,
                stable: mark == Stability::Stable && alike.is_some_and(|mac| mac >= SAME_SHAPE),
                mac: alike,
            }
        })
        .collect()
}
