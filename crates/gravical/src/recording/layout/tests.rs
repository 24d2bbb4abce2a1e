use super::*;
use crate::recording::dialect::sniff;

fn layout(text: &str, spec: Option<&str>) -> Result<Layout> {
    let spec = spec.map(|s| s.parse().unwrap());
    let request = Request {
        columns: spec.as_ref(),
        ..Request::default()
    };
    let dialect = sniff(text.as_bytes(), true, 3).unwrap();
    find(Role::Recording, &dialect, request, &mut Vec::new())
}

#[test]
fn header_with_units_is_assigned() {
    let l = layout(
        "Timestamp,aX (g),aY (g),aZ (g),Temp (C),gX (°/s),gY (°/s),gZ (°/s)\n1,2,3,4,5,6,7,8\n",
        None,
    )
    .unwrap();
    assert_eq!(l.field(Quantity::Gyro(2)), Some(7));
    assert_eq!(l.accel_claim.unit, Some(AccelUnit::StandardGravity));
    assert_eq!(l.gyro_claim, Some(GyroUnit::DegreePerSecond));
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

#[test]
fn the_first_of_two_sensors_is_read_unless_columns_are_given() {
    let text = "l_acc_x,r_acc_x,l_acc_y,r_acc_y,l_acc_z,r_acc_z\n1,2,3,4,5,6\n";
    assert_eq!(
        layout(text, None).unwrap().field(Quantity::Accel(1)),
        Some(2)
    );
    let given = layout(text, Some("ax=r_acc_x,ay=r_acc_y,az=r_acc_z")).unwrap();
    assert_eq!(given.field(Quantity::Accel(1)), Some(3));
}

#[test]
fn without_a_header_columns_are_assigned_by_values() {
    let gyro_first: String = (0..50)
        .map(|i| {
            format!(
                "{} 0.01 0.02 0.1 {} 9.8\n",
                0.03 * f64::from(i % 7),
                0.01 * f64::from(i % 3)
            )
        })
        .collect();
    let l = layout(&gyro_first, None).unwrap();
    assert_eq!(
        (l.field(Quantity::Accel(0)), l.field(Quantity::Gyro(0))),
        (Some(3), Some(0))
    );
    let timed = layout(
        "0.01 33000 33100 36400\n0.02 33000 33100 36400\n0.035 33000 33101 36400\n0.04 1 2 3\n",
        None,
    )
    .unwrap();
    assert_eq!(
        (timed.field(Quantity::Time), timed.field(Quantity::Accel(2))),
        (Some(0), Some(3))
    );
}

#[test]
fn missing_columns_are_errors() {
    assert_eq!(
        layout("a,b,c\n1,2,3\n", None).unwrap_err().code(),
        "no-accelerometer"
    );
    assert_eq!(
        layout("1,2,3,4,5\n1,2,3,4,5\n", None).unwrap_err().code(),
        "columns-unknown"
    );
    assert_eq!(
        layout("p,q,r\n1,2,3\n", Some("ax=p,ay=q,az=x"))
            .unwrap_err()
            .code(),
        "columns-missing"
    );
    assert!("ax,by".parse::<ColumnsSpec>().is_err());
}
