//! Colours, dashes and symbols: Okabe and Ito's palette (2008), which the colour
//! blind can tell apart; dashes and symbols differ too, for print in grey.

use super::super::{Role, Series, Symbol};

/// Family of all text; the last resorts have the symbols that the labels use.
pub(super) const FONT: &str = "system-ui, 'DejaVu Sans', 'Segoe UI', sans-serif";

/// How a role looks in a light page. A style sheet overrides it in a dark one by
/// the class.
pub(super) struct Look {
    /// Class of the group.
    pub class: &'static str,
    /// Stroke and fill.
    pub colour: &'static str,
    /// Dash pattern; empty for a solid line.
    pub dash: &'static str,
    /// Width of lines.
    pub width: f64,
    /// Symbol of points, about 0, 0.
    pub symbol: &'static str,
    /// Symbols are outlines.
    pub hollow: bool,
}

const CIRCLE: &str = "M-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z";
const SQUARE: &str = "M-3.5-3.5h7v7h-7z";
const TRIANGLE: &str = "M0-4.6L4.2 3.2H-4.2z";
const DIAMOND: &str = "M0-5.2L5.2 0L0 5.2L-5.2 0z";
const CROSS: &str = "M-4-4L4 4M-4 4L4-4";
const DOT: &str = "M-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0z";

/// How a series looks: as its role, with a symbol of its own where it has one.
pub(super) fn look_of(series: &Series) -> Look {
    let own = series.symbol.map(|symbol| match symbol {
        Symbol::Circle => CIRCLE,
        Symbol::Square => SQUARE,
        Symbol::Triangle => TRIANGLE,
        Symbol::Diamond => DIAMOND,
        Symbol::Cross => CROSS,
        Symbol::Dot => DOT,
    });
    let look = look(series.role);
    Look {
        symbol: own.unwrap_or(look.symbol),
        ..look
    }
}

pub(super) fn look(role: Role) -> Look {
    let (class, colour, dash, width, symbol, hollow) = match role {
        Role::Raw => ("raw", "#999999", "6 3", 1.4, CIRCLE, true),
        Role::Calibrated => ("calibrated", "#0072B2", "", 1.6, CIRCLE, false),
        Role::Reference => ("reference", "#000000", "1.5 3", 1.4, DOT, false),
        Role::Warning => ("warning", "#E69F00", "", 1.6, DIAMOND, false),
        Role::Bad => ("bad", "#D55E00", "", 1.6, CROSS, true),
        Role::X => ("x", "#D55E00", "", 1.5, CIRCLE, false),
        Role::Y => ("y", "#009E73", "7 2.5", 1.5, SQUARE, false),
        Role::Z => ("z", "#0072B2", "2.5 2", 1.7, TRIANGLE, false),
        Role::Guide => ("guide", "#c8c8c8", "", 0.8, DOT, false),
    };
    Look {
        class,
        colour,
        dash,
        width,
        symbol,
        hollow,
    }
}

/// Rules for a dark page: the same hues, lighter where they would be too dark.
/// Attributes carry the light colours, so that a program without style sheets
/// draws these.
pub(super) const DARK: &str = "\
.gv .paper{fill:#16191d}.gv text{fill:#e6e6e6}.gv .minor{fill:#b4b9bf}\
.gv .frame{stroke:#7d858d}.gv .grid path{stroke:#30363c}.gv .stretch{fill:#2c3a47}\
.gv .reference .s{stroke:#f0f0f0}.gv .reference .f{fill:#f0f0f0}\
.gv .calibrated .s,.gv .z .s{stroke:#56B4E9}.gv .calibrated .f,.gv .z .f{fill:#56B4E9}\
.gv .x .s,.gv .bad .s{stroke:#F0803C}.gv .x .f,.gv .bad .f{fill:#F0803C}\
.gv .y .s{stroke:#2DC89B}.gv .y .f{fill:#2DC89B}\
.gv .raw .s{stroke:#a8a8a8}.gv .raw .f{fill:#a8a8a8}.gv .guide .s{stroke:#4a5057}\
.gv .hollow{fill:#16191d}.gv .halo{stroke:#16191d}";
