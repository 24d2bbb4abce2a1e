use super::*;
use crate::recording::dialect::sniff;

fn layout(text: &str, spec: Option<&str>) -> Result<Layout> {
    let spec = spec.map(|s| s.parse().unwrap());
    let request = Request {
        columns: spec.as_ref(),
        ..Request::default()
    };
    let dialect = sniff(text.as_bytes(), true, 3).unwrap();
    find(&dialect, request)
}

#[test]
fn a_g_behind_an_axis_is_a_unit_where_nothing_is_an_accelerometer() {
    let means = "norm_g,mean_x_g,mean_y_g,mean_z_g,sd_x_g,sd_y_g,sd_z_g\n1,2,3,4,5,6,7\n";
    let l = layout(means, None).unwrap();
    assert_eq!(
        [0, 1, 2].map(|i| l.field(Quantity::Accel(i))),
        [1, 2, 3].map(Some)
    );
    assert_eq!(l.field(Quantity::Gyro(0)), None);
    assert_eq!(l.accel_claim.unit, Some(AccelUnit::StandardGravity));
    // Beside an accelerometer it is the gyroscope.
    let both = layout("x_a,y_a,z_a,x_g,y_g,z_g\n1,2,3,4,5,6\n", None).unwrap();
    assert_eq!(both.field(Quantity::Gyro(2)), Some(5));
}
