//! Colors, the categorical palette and the continuous color maps.

/// An opaque sRGB color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Color {
    /// Red, 0 to 255.
    pub r: u8,
    /// Green, 0 to 255.
    pub g: u8,
    /// Blue, 0 to 255.
    pub b: u8,
}

impl Color {
    /// Blue of the palette.
    pub const BLUE: Self = Self::rgb(0, 114, 178);
    /// Vermilion of the palette.
    pub const VERMILION: Self = Self::rgb(213, 94, 0);
    /// Bluish green of the palette.
    pub const GREEN: Self = Self::rgb(0, 158, 115);
    /// Orange of the palette.
    pub const ORANGE: Self = Self::rgb(230, 159, 0);
    /// Reddish purple of the palette.
    pub const PURPLE: Self = Self::rgb(204, 121, 167);
    /// Sky blue of the palette.
    pub const SKY: Self = Self::rgb(86, 180, 233);
    /// Near black, for text and outlines.
    pub const INK: Self = Self::rgb(34, 34, 34);
    /// Middle gray, for what stands back.
    pub const GRAY: Self = Self::rgb(120, 120, 120);
    /// Light gray, for fills and grids.
    pub const LIGHT: Self = Self::rgb(225, 225, 225);
    /// White.
    pub const WHITE: Self = Self::rgb(255, 255, 255);

    /// Categorical colors told apart with every kind of color vision.
    ///
    /// # Source
    /// Okabe & Ito (2008), Color Universal Design.
    pub const PALETTE: [Self; 6] =
        [Self::BLUE, Self::VERMILION, Self::GREEN, Self::ORANGE, Self::PURPLE, Self::SKY];

    /// A color from its sRGB components.
    pub const fn rgb(r: u8, g: u8, b: u8) -> Self {
        Self { r, g, b }
    }

    /// The palette's color number `index`, starting again after the last.
    pub const fn cycle(index: usize) -> Self {
        Self::PALETTE[index % Self::PALETTE.len()]
    }

    /// The color mixed with black (`light` < 1) or white (`light` > 1); 0 is black, 2 is white.
    pub fn lit(self, light: f64) -> Self {
        let light = light.clamp(0.0, 2.0);
        let mix = |value: u8| {
            let value = f64::from(value);
            let lit =
                if light <= 1.0 { value * light } else { value + (255.0 - value) * (light - 1.0) };
            lit.round() as u8
        };
        Self::rgb(mix(self.r), mix(self.g), mix(self.b))
    }

    pub(crate) fn hex(self) -> String {
        let full = format!("#{:02x}{:02x}{:02x}", self.r, self.g, self.b);
        let digits = full.as_bytes();
        if digits[1] == digits[2] && digits[3] == digits[4] && digits[5] == digits[6] {
            return [digits[0], digits[1], digits[3], digits[5]].map(char::from).iter().collect();
        }
        full
    }
}

/// A perceptually ordered color map from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMap {
    /// Sequential, dark blue to yellow.
    Viridis,
    /// Sequential, made for color-vision deficiency, blue to yellow.
    Cividis,
    /// Diverging, blue over white to red, for signed values about 0.
    Diverging,
}

impl ColorMap {
    /// The color at `t`, clamped to 0 to 1.
    pub fn at(self, t: f64) -> Color {
        let t = t.clamp(0.0, 1.0);
        let color = match self {
            Self::Viridis => colorous::VIRIDIS.eval_continuous(t),
            Self::Cividis => colorous::CIVIDIS.eval_continuous(t),
            Self::Diverging => colorous::RED_BLUE.eval_continuous(1.0 - t),
        };
        Color::rgb(color.r, color.g, color.b)
    }
}

/// A color map with the values at its two ends and, if labelled, a color bar.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorScale {
    pub(crate) map: ColorMap,
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) label: Option<String>,
}

impl ColorScale {
    /// The scale over `values`, symmetric about 0 for a diverging map, unless `range` is given.
    pub fn fit(
        map: ColorMap,
        range: Option<(f64, f64)>,
        label: Option<String>,
        values: impl Iterator<Item = f64>,
    ) -> Self {
        let (low, high) = range.unwrap_or_else(|| {
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            if map == ColorMap::Diverging {
                let reach = low.abs().max(high.abs());
                (-reach, reach)
            } else {
                (low, high)
            }
        });
        if low < high {
            return Self { map, low, high, label };
        }
        let reach = if low == 0.0 { 1.0 } else { 0.05 * low.abs() };
        Self { map, low: low - reach, high: low + reach, label }
    }

    /// The color of a value, clamped to the ends of the scale.
    pub fn color(&self, value: f64) -> Color {
        self.map.at((value - self.low) / (self.high - self.low))
    }
}

#[cfg(test)]
mod tests {
    use super::{Color, ColorMap, ColorScale};

    fn luma(color: Color) -> f64 {
        0.2126 * f64::from(color.r) + 0.7152 * f64::from(color.g) + 0.0722 * f64::from(color.b)
    }

    #[test]
    fn sequential_maps_brighten_all_the_way() {
        for map in [ColorMap::Viridis, ColorMap::Cividis] {
            let lumas: Vec<f64> = (0..=20).map(|i| luma(map.at(f64::from(i) / 20.0))).collect();
            assert!(lumas.windows(2).all(|pair| pair[1] > pair[0]), "{map:?}: {lumas:?}");
        }
    }

    #[test]
    fn diverging_map_is_blue_below_zero_pale_at_zero_and_red_above() {
        let scale = ColorScale::fit(ColorMap::Diverging, None, None, [-1.0, 4.0].into_iter());
        assert_eq!((scale.low, scale.high), (-4.0, 4.0));
        assert!(scale.color(-3.0).b > scale.color(-3.0).r);
        assert!(luma(scale.color(0.0)) > 235.0);
        assert!(scale.color(3.0).r > scale.color(3.0).b);
    }

    #[test]
    fn constant_values_still_have_a_scale() {
        for value in [0.0, -2.0, 5.0] {
            for map in [ColorMap::Viridis, ColorMap::Diverging] {
                let scale = ColorScale::fit(map, None, None, [value].into_iter());
                assert!(scale.low < scale.high, "{value} {map:?}");
            }
        }
    }

    #[test]
    fn hex_is_as_short_as_it_can_be() {
        assert_eq!(Color::WHITE.hex(), "#fff");
        assert_eq!(Color::BLUE.hex(), "#0072b2");
    }
}
