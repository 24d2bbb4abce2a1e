//! Figures as PNG.

use std::io::{Error, Result};
use std::sync::{Arc, LazyLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::{Figure, svg};

/// Dots of the picture for one of the drawing: sharp in print at the usual width
/// of a page.
const ZOOM: f32 = 2.0;

/// DejaVu Sans, which has the symbols of the labels; a picture is the same on every
/// machine, whatever fonts it has.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.load_font_data(dejavu::sans::bold().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

/// The figure as it is drawn in a light page.
///
/// # Errors
///
/// What the renderer says.
pub(super) fn png(figure: &Figure) -> Result<Vec<u8>> {
    let failed = |what: String| Error::other(format!("the drawing was not rendered: {what}"));
    let options = Options {
        fontdb: FONTS.clone(),
        font_family: "DejaVu Sans".to_owned(),
        ..Options::default()
    };
    let tree =
        Tree::from_str(&svg::standalone(figure), &options).map_err(|e| failed(e.to_string()))?;
    let size = tree.size().to_int_size().scale_by(ZOOM);
    let size = size.ok_or_else(|| failed("no size".to_owned()))?;
    let mut picture =
        Pixmap::new(size.width(), size.height()).ok_or_else(|| failed("too large".to_owned()))?;
    resvg::render(
        &tree,
        Transform::from_scale(ZOOM, ZOOM),
        &mut picture.as_mut(),
    );
    picture.encode_png().map_err(|e| failed(e.to_string()))
}
