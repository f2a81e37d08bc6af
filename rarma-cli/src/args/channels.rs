//! Options of `identify` for several channels at once.

use clap::Args;

/// Channels that are fitted together.
#[derive(Debug, Clone, Args)]
pub struct ChannelArgs {
    /// Fit these channels together, counted from 0, or `all` of them: frequency, damping and mode
    /// shape by covariance-driven subspace identification. --order is N,0 then: N states, two for
    /// each mode.
    #[arg(long, value_name = "all|0,1,...", value_parser = set,
          conflicts_with_all = ["channel", "method", "forgetting", "random_walk"])]
    pub channels: Option<ChannelSet>,
    /// Those of them that the others are correlated with, by the same numbers [default: all].
    #[arg(long, value_name = "0,1,...", value_parser = set, requires = "channels")]
    pub references: Option<ChannelSet>,
    /// Block rows of the matrix of covariances, 2 to 200: lags 1 to 2·rows - 1 are used.
    #[arg(long, value_name = "N", default_value_t = 20, requires = "channels",
          value_parser = clap::value_parser!(u16).range(2..=200))]
    pub rows: u16,
    /// Stretches that the recording is cut into for the deviations, 10 to 1000.
    #[arg(long, value_name = "N", default_value_t = 100, requires = "channels",
          value_parser = clap::value_parser!(u16).range(10..=1000))]
    pub stretches: u16,
}

/// Channels of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ChannelSet {
    /// All there are.
    All,
    /// These, each once, counted from 0.
    These(Vec<usize>),
}

pub(super) fn set(text: &str) -> Result<ChannelSet, String> {
    if text.trim() == "all" {
        return Ok(ChannelSet::All);
    }
    let mut these = Vec::new();
    for word in text.split(',') {
        let channel: usize = word
            .trim()
            .parse()
            .map_err(|_| "must be `all`, or numbers of channels such as 0,1,2".to_owned())?;
        if these.contains(&channel) {
            return Err(format!("names channel {channel} twice"));
        }
        these.push(channel);
    }
    Ok(ChannelSet::These(these))
}

#[cfg(test)]
mod tests {
    use super::{ChannelSet, set};

    #[test]
    fn sets_are_read_or_refused() {
        assert_eq!(set("all"), Ok(ChannelSet::All));
        assert_eq!(set("2, 0"), Ok(ChannelSet::These(vec![2, 0])));
        for wrong in ["", "1,", "-1", "1,1", "0.5", "first"] {
            assert!(set(wrong).is_err(), "{wrong}");
        }
    }
}
