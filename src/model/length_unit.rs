//! The unit of a file's lengths, for formats that name none.

use std::fmt;
use std::str::FromStr;

/// A name that belongs to no unit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("no unit of length is called '{0}'")]
pub struct UnknownUnit(pub String);

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum LengthUnit {
    /// Micrometre.
    Micrometre,
    /// Millimetre.
    #[default]
    Millimetre,
    /// Centimetre.
    Centimetre,
    /// Metre.
    Metre,
    /// Inch, 25.4 mm.
    Inch,
    /// Foot, twelve inches.
    Foot,
}

impl LengthUnit {
    /// Every unit with its name on the command line and in reports.
    pub const NAMED: [(&'static str, Self); 6] = [
        ("um", Self::Micrometre),
        ("mm", Self::Millimetre),
        ("cm", Self::Centimetre),
        ("m", Self::Metre),
        ("in", Self::Inch),
        ("ft", Self::Foot),
    ];

    /// Its length in mm.
    pub fn mm(self) -> f64 {
        match self {
            Self::Micrometre => 1e-3,
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
            Self::Foot => 304.8,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::NAMED
            .iter()
            .find(|(_, unit)| *unit == self)
            .map_or("", |(name, _)| name)
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for LengthUnit {
    type Err = UnknownUnit;
    fn from_str(text: &str) -> Result<Self, UnknownUnit> {
        Self::NAMED
            .iter()
            .find(|(name, _)| *name == text)
            .map(|(_, unit)| *unit)
            .ok_or_else(|| UnknownUnit(text.to_owned()))
    }
}

impl serde::Serialize for LengthUnit {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_a_name_that_leads_back_to_it() {
        for (name, unit) in LengthUnit::NAMED {
            assert_eq!(name.parse(), Ok(unit));
            assert_eq!(unit.to_string(), name);
        }
        assert_eq!(
            "parsec".parse::<LengthUnit>(),
            Err(UnknownUnit("parsec".into()))
        );
    }

    #[test]
    fn the_units_are_as_long_as_they_are() {
        assert_eq!(LengthUnit::default().mm(), 1.0);
        assert!((12.0 * LengthUnit::Inch.mm() - LengthUnit::Foot.mm()).abs() < 1e-12);
        assert!(
            (LengthUnit::Metre.mm() / LengthUnit::Micrometre.mm() - 1e6).abs() < 1e-6,
            "a million"
        );
    }
}
