//! Files from the future: a file may say which version of its kind it was written for, and one newer than ours is refused.

use serde::{Deserialize, Deserializer, de};

/// The version of every kind of TOML file there is (machines, scenes, sweeps).
pub const VERSION: u32 = 1;

/// `schema = 1` in a TOML file, or nothing. All that can be read are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Schema;

impl<'de> Deserialize<'de> for Schema {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let version = u32::deserialize(deserializer)?;
        if (1..=VERSION).contains(&version) {
            return Ok(Self);
        }
        Err(de::Error::custom(format!("schema {version}, and this texunit reads up to {VERSION}: update texunit")))
    }
}
