//! Conversions of ADC3 to ADC5, triggered by the bridges' timer once a PWM period.

use embassy_stm32::adc::{Exten, SampleTime};
use embassy_stm32::pac::adc::Adc;

/// 24.5 cycles of 40.8 MHz: 0.6 µs for the source to settle.
const TIME: SampleTime = SampleTime::CYCLES24_5;

/// Converts up to four channels, in their order, at every trigger.
pub(super) fn start(adc: Adc, channels: &[u8], trigger: u8) {
    for &channel in channels {
        if channel < 10 {
            adc.smpr().modify(|w| w.set_smp(channel.into(), TIME));
        } else {
            adc.smpr2()
                .modify(|w| w.set_smp(usize::from(channel) - 10, TIME));
        }
    }
    adc.jsqr().write(|w| {
        w.set_jl(channels.len() as u8 - 1);
        for (rank, &channel) in channels.iter().enumerate() {
            w.set_jsq(rank, channel);
        }
        w.set_jextsel(trigger);
        w.set_jexten(Exten::RISING_EDGE);
    });
    adc.cr().modify(|w| w.set_jadstart(true));
}

/// Whether all channels were converted since the last call.
pub(super) fn take(adc: Adc) -> bool {
    let done = adc.isr().read().jeos();
    adc.isr().write(|w| {
        w.set_jeoc(true);
        w.set_jeos(true);
    });
    done
}
