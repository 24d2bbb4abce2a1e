//! Columns that the user names.

use super::format::Format;
use crate::error::Error;
use crate::options::ColumnsSpec;
use crate::role::Role;

/// Gives the columns that the user names their roles; no other column keeps such a role.
pub(crate) fn assign(format: &mut Format) -> Result<(), Error> {
    let Some(spec) = format.options.columns.clone() else {
        return Ok(());
    };
    let is_read = |role: Role| {
        let is_gyro = matches!(role, Role::Gyro(_));
        !format.options.is_gyroscope || is_gyro || matches!(role, Role::Time | Role::Step)
    };
    let mut given: Vec<(usize, Role)> = Vec::new();
    let mut unread: Vec<Role> = Vec::new();
    match spec {
        ColumnsSpec::Ordered(order) => {
            let names_gyro = |role: &Option<Role>| matches!(role, Some(Role::Gyro(_)));
            if format.options.is_gyroscope && !order.iter().any(names_gyro) {
                return Ok(());
            }
            if order.len() > format.columns.len() {
                let (named, columns) = (order.len(), format.columns.len());
                let text = format!("{named} columns are named, the file has {columns}");
                return Err(missing(text).with_hint("leave the last ones out"));
            }
            let columns = order.into_iter().enumerate();
            given.extend(columns.filter_map(|(column, role)| Some((column, role?))));
        }
        ColumnsSpec::Named(pairs) => {
            for (role, name) in pairs.into_iter().filter(|(role, _)| is_read(*role)) {
                match name {
                    None if !format.options.is_gyroscope => unread.push(role),
                    None => {}
                    Some(name) => match find(&format.names, &name) {
                        Some(column) => given.push((column, role)),
                        // The clock of the accelerometer's file.
                        None if format.options.is_gyroscope && role == Role::Time => {}
                        None => {
                            let text = format!("there is no column \"{name}\"");
                            return Err(missing(text).with_hint(list_columns(&format.names)));
                        }
                    },
                }
            }
        }
    }
    let is_clock = |role: &Role| matches!(role, Role::Time | Role::Step);
    let names_clock = given.iter().map(|g| &g.1).chain(&unread).any(is_clock);
    for column in &mut format.columns {
        let is_taken = unread.contains(&column.role) || given.iter().any(|g| g.1 == column.role);
        if is_taken || names_clock && is_clock(&column.role) {
            column.role = Role::Other;
            column.is_dropped = true;
        }
    }
    for (column, role) in given {
        let column = &mut format.columns[column];
        column.role = role;
        column.is_given = true;
        column.is_dropped = role == Role::Other;
    }
    format.has_no_clock = names_clock && !format.columns.iter().any(|c| is_clock(&c.role));
    Ok(())
}

fn missing(text: String) -> Error {
    Error::usage("columns-missing", text).of_option("columns")
}

/// Names of columns that a hint lists.
const MAX_LISTED: usize = 16;

/// A hint that lists the columns of a file.
pub(super) fn list_columns(names: &[String]) -> String {
    if names.is_empty() {
        return "the file has no header: give the channels in order, as t,ax,ay,az".to_owned();
    }
    let names = names.iter().map(String::as_str);
    let list: Vec<&str> = names.filter(|n| !n.is_empty()).collect();
    let more = if list.len() > MAX_LISTED { ", …" } else { "" };
    let shown = list[..list.len().min(MAX_LISTED)].join(", ");
    format!("its columns are: {shown}{more}; assign them, as ax=…,ay=…,az=…")
}

fn find(names: &[String], name: &str) -> Option<usize> {
    let exact = names.iter().position(|n| n == name);
    exact.or_else(|| names.iter().position(|n| n.eq_ignore_ascii_case(name)))
}
