//! What a column holds.

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

impl Role {
    /// A name for a column that holds it; `column` counts from 0.
    pub(crate) fn name(self, column: usize) -> String {
        let axis = |i: usize| ["x", "y", "z"][i];
        match self {
            Role::Time => "time".to_owned(),
            Role::Step => "dt".to_owned(),
            Role::Accel(i) => format!("a{}", axis(i)),
            Role::Gyro(i) => format!("g{}", axis(i)),
            Role::Temperature => "temp".to_owned(),
            Role::Label => "label".to_owned(),
            Role::Other => format!("c{}", column + 1),
        }
    }
}
