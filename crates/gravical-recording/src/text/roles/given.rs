//! Columns that the user names.

use gravical_judge::{ColumnsSpec, Role};

use crate::problem::Problem;
use crate::text::format::Format;

/// Gives the columns that the user names their roles; no other column keeps such a role.
pub(super) fn assign(format: &mut Format) -> Result<(), Problem> {
    let is_gyroscope = format.options.is_gyroscope;
    let is_clock = |role: &Role| matches!(role, Role::Time | Role::Step);
    let is_gyro = |role: &Role| matches!(role, Role::Gyro(_));
    // The column of each role; none for a role that is not read.
    let mut given: Vec<(Role, Option<usize>)> = Vec::new();
    match format.options.columns.clone() {
        None => return Ok(()),
        Some(ColumnsSpec::Ordered(order)) => {
            if is_gyroscope && !order.iter().flatten().any(is_gyro) {
                return Ok(());
            }
            if order.len() > format.columns.len() {
                let (named, columns) = (order.len(), format.columns.len());
                return Err(Problem::TooManyNamed { named, columns });
            }
            let columns = order.into_iter().enumerate();
            given.extend(columns.filter_map(|(column, role)| Some((role?, Some(column)))));
        }
        Some(ColumnsSpec::Named(pairs)) => {
            for (role, name) in pairs {
                let column = name.as_ref().and_then(|n| find_column(&format.names, n));
                match (column, name) {
                    // The columns of the accelerometer's file, and its clock.
                    _ if is_gyroscope && !is_gyro(&role) && !is_clock(&role) => {}
                    (None, None) if is_gyroscope => {}
                    (None, Some(_)) if is_gyroscope && role == Role::Time => {}
                    (None, Some(name)) => {
                        let names = format.names.clone();
                        return Err(Problem::NoColumn { name, names });
                    }
                    _ => given.push((role, column)),
                }
            }
        }
    }
    let names_clock = given.iter().any(|(role, _)| is_clock(role));
    for column in &mut format.columns {
        let is_taken = given.iter().any(|(role, _)| *role == column.role);
        if is_taken || names_clock && is_clock(&column.role) {
            column.role = Role::Other;
            column.is_dropped = true;
        }
    }
    for (role, column) in given {
        if let Some(column) = column.map(|c| &mut format.columns[c]) {
            column.role = role;
            column.is_given = true;
            column.is_dropped = role == Role::Other;
        }
    }
    format.has_no_clock = names_clock && !format.columns.iter().any(|c| is_clock(&c.role));
    Ok(())
}

fn find_column(names: &[String], name: &str) -> Option<usize> {
    let exact = names.iter().position(|n| n == name);
    exact.or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)))
}
