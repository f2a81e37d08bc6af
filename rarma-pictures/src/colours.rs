//! The colour scale of the waterfall, and its bitmap.
//!
//! The scale runs from dark blue over grey to yellow. Its lightness rises
//! evenly and hue moves only along the axis that colour-blind eyes keep, so it
//! reads the same for them and in grey; print turns it over, to spare ink.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Colours told apart; more would only make the bitmap larger.
pub const SHADES: usize = 64;

/// Support points of the scale, red green blue.
const SUPPORT: [[f64; 3]; 6] = [
    [0.0, 30.0, 74.0],
    [46.0, 68.0, 108.0],
    [101.0, 104.0, 113.0],
    [147.0, 142.0, 120.0],
    [201.0, 186.0, 105.0],
    [255.0, 235.0, 80.0],
];

/// Colour at `share` of the scale, 0 to 1.
fn colour(share: f64) -> [u8; 3] {
    let place = share.clamp(0.0, 1.0) * (SUPPORT.len() - 1) as f64;
    let i = (place as usize).min(SUPPORT.len() - 2);
    let rest = place - i as f64;
    std::array::from_fn(|k| {
        (SUPPORT[i][k] + rest * (SUPPORT[i + 1][k] - SUPPORT[i][k])).round() as u8
    })
}

/// Stops of an SVG gradient, dark to bright.
pub fn gradient_stops() -> String {
    let mut stops = String::new();
    for i in 0..SUPPORT.len() {
        let share = i as f64 / (SUPPORT.len() - 1) as f64;
        let [r, g, b] = colour(share);
        put!(
            stops,
            r##"<stop offset="{share}" stop-color="#{r:02x}{g:02x}{b:02x}"/>"##
        );
    }
    stops
}

/// A bitmap of shades, row by row from the top, as a data address.
pub fn bitmap(width: usize, height: usize, shades: &[u8]) -> Option<String> {
    let palette: Vec<u8> = (0..SHADES)
        .flat_map(|i| colour(i as f64 / (SHADES - 1) as f64))
        .collect();
    let mut file = Vec::new();
    let (w, h) = (u32::try_from(width).ok()?, u32::try_from(height).ok()?);
    let mut encoder = png::Encoder::new(&mut file, w, h);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(shades).ok()?;
    writer.finish().ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(&file)))
}
