//! What a column holds.

use crate::units::is_listed;

/// What a column holds. Axes are 0, 1, 2 for x, y, z.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Role {
    /// Time of the row
    Time,
    /// Time since the row before
    Step,
    /// Specific force along an axis
    Accel(usize),
    /// Angular rate about an axis
    Gyro(usize),
    /// Temperature
    Temperature,
    /// Name of the placement or section
    Label,
    /// Anything else
    #[default]
    Other,
}

/// The name of each, and others that a user may give.
const NAMES: [(Role, &str); 10] = [
    (Role::Time, "time t"),
    (Role::Step, "dt"),
    (Role::Accel(0), "ax"),
    (Role::Accel(1), "ay"),
    (Role::Accel(2), "az"),
    (Role::Gyro(0), "gx"),
    (Role::Gyro(1), "gy"),
    (Role::Gyro(2), "gz"),
    (Role::Temperature, "temp temperature"),
    (Role::Label, "label part"),
];

impl Role {
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        let named = NAMES.iter().find(|(_, names)| is_listed(names, name));
        named.map(|(role, _)| *role)
    }

    /// A name for a column that holds it; `column` counts from 0.
    pub fn name(self, column: usize) -> String {
        let named = NAMES.iter().find(|(role, _)| *role == self);
        let name = named.and_then(|(_, names)| names.split(' ').next());
        name.map_or_else(|| format!("c{}", column + 1), str::to_owned)
    }
}
