//! What a column holds.

/// What a column holds. Axes are 0, 1, 2 for x, y, z.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
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
    Other,
}
