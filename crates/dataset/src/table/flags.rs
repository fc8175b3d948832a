//! The flags of a table row: a documented set of remarks that a model may filter by.

use std::{
    fmt,
    ops::{BitOr, BitOrAssign},
    str::FromStr,
};

/// What is special about a row; written as names joined by `|`, nothing for an ordinary row.
#[derive(Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Flags(u32);

impl Flags {
    /// The recording begins with the contact already made.
    pub const STARTS_IN_CONTACT: Self = Self(1);
    /// A vertex of the outline is touched at the start.
    pub const VERTEX: Self = Self(1 << 1);
    /// The contact point is within a stated distance of a vertex at the start or the end.
    pub const NEAR_VERTEX: Self = Self(1 << 2);
    /// The step begins within a stated time or way of the first contact.
    pub const FIRST_TOUCH: Self = Self(1 << 3);
    /// The contact opens within the step, by force or by geometry.
    pub const CONTACT_LOST: Self = Self(1 << 4);
    /// The object's stream has a gap beyond the limit within the step (not at its ends).
    pub const OBJECT_GAP: Self = Self(1 << 5);
    /// The robot's stream has a gap beyond the limit within the step (not at its ends).
    pub const ROBOT_GAP: Self = Self(1 << 6);
    /// The zero of the force sensor is not known: forces are as recorded.
    pub const UNTARED: Self = Self(1 << 7);
    /// Another edge is touched at the end than at the start.
    pub const EDGE_CHANGED: Self = Self(1 << 8);
    /// The step is shorter than asked for: what was left before the contact or the motion ended.
    pub const SHORT: Self = Self(1 << 9);
    /// Pusher and outline overlap by more than a stated length at the start or the end.
    pub const PENETRATION: Self = Self(1 << 10);
    /// The pusher moves away from what it is nearest to at the start, an edge or a vertex: more than 90°
    /// from the contact normal.
    pub const MOVING_AWAY: Self = Self(1 << 11);
    /// The pusher rests: its direction is not defined.
    pub const PUSHER_AT_REST: Self = Self(1 << 12);
    /// The step is a whole push, from before the first touch: of the object no more is known than where
    /// it was before and after. With `starts_in_contact` the pusher touches from the start on.
    pub const WHOLE_PUSH: Self = Self(1 << 13);

    /// Every flag with its name.
    pub const ALL: [(Self, &'static str); 14] = [
        (Self::STARTS_IN_CONTACT, "starts_in_contact"),
        (Self::VERTEX, "vertex"),
        (Self::NEAR_VERTEX, "near_vertex"),
        (Self::FIRST_TOUCH, "first_touch"),
        (Self::CONTACT_LOST, "contact_lost"),
        (Self::OBJECT_GAP, "object_gap"),
        (Self::ROBOT_GAP, "robot_gap"),
        (Self::UNTARED, "untared"),
        (Self::EDGE_CHANGED, "edge_changed"),
        (Self::SHORT, "short"),
        (Self::PENETRATION, "penetration"),
        (Self::MOVING_AWAY, "moving_away"),
        (Self::PUSHER_AT_REST, "pusher_at_rest"),
        (Self::WHOLE_PUSH, "whole_push"),
    ];

    /// Whether all flags of `other` are set.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether no flag is set.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Sets `other` if `condition` holds.
    pub(crate) fn set_if(&mut self, other: Self, condition: bool) {
        if condition {
            *self |= other;
        }
    }
}

impl BitOr for Flags {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Flags {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Display for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = Self::ALL.iter().filter(|(flag, _)| self.contains(*flag));
        f.write_str(&names.map(|(_, name)| *name).collect::<Vec<_>>().join("|"))
    }
}

impl fmt::Debug for Flags {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Flags({self})")
    }
}

impl FromStr for Flags {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut flags = Self::default();
        for name in text.split('|').filter(|name| !name.is_empty()) {
            match Self::ALL.iter().find(|(_, known)| *known == name) {
                Some((flag, _)) => flags |= *flag,
                None => {
                    let known: Vec<_> = Self::ALL.iter().map(|(_, name)| *name).collect();
                    return Err(format!("flags out of {}, joined by |", known.join(", ")));
                }
            }
        }
        Ok(flags)
    }
}

#[cfg(test)]
mod tests {
    use super::Flags;

    #[test]
    fn every_flag_is_its_own_bit_and_survives_text() {
        let mut all = Flags::default();
        for (flag, _) in Flags::ALL {
            assert!(!all.contains(flag));
            all |= flag;
            assert_eq!(flag.to_string().parse(), Ok(flag));
        }
        assert_eq!(all.to_string().parse(), Ok(all));
        assert_eq!("".parse(), Ok(Flags::default()));
        assert!("vertex|corner".parse::<Flags>().unwrap_err().contains("near_vertex"));
    }
}
