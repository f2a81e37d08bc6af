//! The one table of pins. It makes the board's set of pins and the page docs/wiring.md.

/// Calls `$with! { $context name: PIN, "function", "connector", "signal"; … }` for every pin
/// of the board. Whether a pin has the function named is checked where the HAL is given it.
macro_rules! with_every_pin {
    ($with:ident $(, $context:ident)?) => {
        $with! { $($context)?;
            microphone_1: PA0, "ADC1_IN1", "CN7-28 (A0)", "first microphone: 0 to 3.3 V around 1.65 V";
            microphone_2: PA1, "ADC2_IN2", "CN7-30 (A1)", "second microphone, likewise";
            tacho: PB10, "TIM2_CH3", "CN10-25", "spindle tacho: one pulse a turn, rising edge, 3.3 V";
            coil_x1_high: PC0, "TIM1_CH1", "CN7-38", "coil +X, gate of the upper switch";
            coil_x1_low: PA11, "TIM1_CH1N", "CN10-14", "coil +X, gate of the lower switch";
            coil_x2_high: PC1, "TIM1_CH2", "CN7-36", "coil -X, gate of the upper switch";
            coil_x2_low: PA12, "TIM1_CH2N", "CN10-12", "coil -X, gate of the lower switch";
            coil_y1_high: PC2, "TIM1_CH3", "CN7-35", "coil +Y, gate of the upper switch";
            coil_y1_low: PB9, "TIM1_CH3N", "CN10-5", "coil +Y, gate of the lower switch";
            coil_y2_high: PC3, "TIM1_CH4", "CN7-37", "coil -Y, gate of the upper switch";
            coil_y2_low: PC5, "TIM1_CH4N", "CN10-6", "coil -Y, gate of the lower switch";
            current_x1: PB1, "ADC3_IN1, COMP1_INP", "CN10-24", "current of coil +X";
            current_x2: PB0, "ADC3_IN12, COMP4_INP", "CN7-34 (A3)", "current of coil -X";
            current_y1: PB13, "ADC3_IN5, COMP5_INP", "CN10-30", "current of coil +Y";
            current_y2: PB14, "ADC4_IN4, COMP7_INP", "CN10-28", "current of coil -Y";
            gap_x: PB12, "ADC4_IN3", "CN10-16", "displacement sensor X";
            gap_y: PB15, "ADC4_IN5", "CN10-26", "displacement sensor Y";
            valve: PA4, "DAC1_OUT1", "CN7-32 (A2)", "set point of the pressure valve";
            pressure: PA8, "ADC5_IN1", "CN10-23", "pressure sensor";
            gauge: PA9, "ADC5_IN2", "CN10-21", "length gauge";
            supply: PB11, "OPAMP4_VINP, ADC5_IN5", "CN10-18", "supply of the power stage, divided";
            emergency_stop: PA6, "TIM1_BKIN", "CN10-13", "high: may run; low or open: all coils off, without software";
            enable: PC8, "input, pulled down", "CN10-2", "high: the operator allows power";
            power_stage: PC9, "output, off at reset", "CN10-1", "high: the gate drivers may switch; needs a pull-down there";
            led_alive: PA5, "output", "LD2 on the board", "blinks: the program runs";
            led_energised: PC10, "output", "CN7-1", "lit: outputs are on";
            led_warning: PC11, "output", "CN7-2", "lit: chatter, or a fault";
            link_out: PA2, "USART2_TX", "debugger's serial port", "frames to the host, 921600 baud, 8N1";
            link_in: PA3, "USART2_RX", "debugger's serial port", "commands from the host";
        }
    };
}

/// A pin and what it is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pin {
    /// Its name in the code.
    pub name: &'static str,
    /// The chip's pin.
    pub pin: &'static str,
    /// What of the chip it leads to.
    pub function: &'static str,
    /// Where on the board it is.
    pub connector: &'static str,
    /// What to connect.
    pub signal: &'static str,
}

macro_rules! rows {
    (; $($name:ident: $pin:ident, $function:literal, $connector:literal, $signal:literal;)*) => {
        /// Every pin that the firmware uses.
        pub const PINS: &[Pin] = &[$(Pin {
            name: stringify!($name),
            pin: stringify!($pin),
            function: $function,
            connector: $connector,
            signal: $signal,
        }),*];
    };
}
with_every_pin!(rows);

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = include_str!("../../../../docs/wiring.md");
    const BEGIN: &str = "<!-- pins:begin -->\n";
    const END: &str = "<!-- pins:end -->";

    fn table() -> String {
        let mut text = String::from(
            "| pin | where | what to connect | function of the chip | name in the code |\n|---|---|---|---|---|\n",
        );
        for pin in PINS {
            text += &format!(
                "| {} | {} | {} | {} | `{}` |\n",
                pin.pin, pin.connector, pin.signal, pin.function, pin.name
            );
        }
        text
    }

    #[test]
    fn the_page_shows_this_table() {
        let (_, rest) = PAGE.split_once(BEGIN).expect("the page has its marker");
        let (shown, _) = rest
            .split_once(END)
            .expect("the page has its second marker");
        let made = table();
        assert_eq!(shown, made, "docs/wiring.md must hold:\n{made}");
    }

    #[test]
    fn no_pin_is_used_twice() {
        let mut pins: Vec<_> = PINS.iter().map(|pin| pin.pin).collect();
        pins.sort_unstable();
        pins.dedup();
        assert_eq!(pins.len(), PINS.len());
        for taken in ["PA13", "PA14", "PF0", "PF1", "PG10", "PB8"] {
            assert!(
                !pins.contains(&taken),
                "{taken} is the debugger's, the crystal's, reset or boot"
            );
        }
    }
}
