//! The first lines of loggers and apps as they write them.

use gravical_recording::{AccelUnit, ReadOptions, read_bytes};

use crate::support::{RATE_HZ, Row, has, has_rate, is_near, read, six_faces};

const G: f64 = 9.80665;

/// Of each: name, name of the file, unit of the accelerometer (or counts per g) and of the gyroscope (or counts
/// per °/s), and decimal sign; the header, if any; and behind `>` how a row is written. There `$x`, `$y`, `$z`
/// are the specific force (`$X` … in ten places), `$u`, `$v`, `$w` the angular rate, `$k` the number of the
/// row, `$S` and `$T` its seconds (`$T` with two digits before the point), `$P` with a colon for the point;
/// `$M`, `$U` milliseconds and microseconds, `$E`, `$N` milliseconds and nanoseconds since 1970, and `$A`, `$B`
/// seconds and nanoseconds of one stamp. `$O` is a list of nine zeros, an arrow a tabulator.
const SHAPES: &str = r#"
fixed width | - | m/s^2 | - | .
> $X$Y$Z

Sensor Logger | TotalAcceleration.csv | m/s^2 | - | .
time,seconds_elapsed,z,y,x
> $N,$S,$z,$y,$x

Physics Toolbox | - | g | - | ,
time;gFx;gFy;gFz;TgF
> 11:41:$P;$x;$y;$z;1,000

ros2 topic echo --csv | - | m/s^2 | rad/s | .
> $A,$B,imu,0,0,0,1,0,0,0,0,0,0,0,0,0,$u,$v,$w,0,0,0,0,0,0,0,0,0,$x,$y,$z,0,0,0,0,0,0,0,0,0

with and without gravity | - | m/s^2 | - | .
time,linear_acceleration_x,linear_acceleration_y,linear_acceleration_z,acceleration_x,acceleration_y,acceleration_z
> $S,0.01,0.02,0.03,$x,$y,$z

ulog2csv | - | m/s^2 | rad/s | .
timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt
> $U,$u,$v,$w,40000,0,$x,$y,$z,40000

blackbox_decode | - | 2048 | deg/s | .
loopIteration, time (us), axisP[0], axisP[1], axisP[2], gyroADC[0], gyroADC[1], gyroADC[2], accSmooth[0], accSmooth[1], accSmooth[2], motor[0]
> $k, $U, 0, 0, 0, $u, $v, $w, $x, $y, $z, 1000

Axivity | - | g | - | .
> 2017-05-19 14:31:$T,$x,$y,$z

Shimmer | - | m/s^2 | - | .
"sep=\t"
S_Timestamp_CAL→S_Accel_LN_X_CAL→S_Accel_LN_Y_CAL→S_Accel_LN_Z_CAL→S_Accel_WR_X_CAL→S_Accel_WR_Y_CAL→S_Accel_WR_Z_CAL→
ms→m/(s^2)→m/(s^2)→m/(s^2)→m/(s^2)→m/(s^2)→m/(s^2)→
> $E→$x→$y→$z→$z→$x→$y→

MbientLab | MetaWear_Accelerometer.csv | g | - | .
epoc (ms),timestamp (+0200),elapsed (s),x-axis (g),y-axis (g),z-axis (g)
> $E,2020-09-13T14:26:$T,$S,$x,$y,$z

Adafruit | log.txt | m/s^2 | rad/s | .
> Acceleration X: $x, Y: $y, Z: $z m/s^2
> Rotation X: $u, Y: $v, Z: $w rad/s
> Temperature: 27.31 degC
>

i2cdevlib | log.txt | 16384 | 131 | .
> a/g:→$x→$y→$z→$u→$v→$w

key equals value | log.txt | g | deg/s | .
> aX = $x | aY = $y | aZ = $z | tmp = 27.31 | gX = $u | gY = $v | gZ = $w

spreadsheet | - | g | - | ,
t,az,ay,ax
> "$S","$z","$y","$x"

Serial Monitor | log.txt | m/s^2 | - | .
> 14:03:$T -> $x,$y,$z

SparkFun | log.txt | mg | deg/s | .
> Scaled. Acc (mg) [ $x, $y, $z ], Gyr (DPS) [ $u, $v, $w ]

esp-idf | log.txt | g | - | .
> I ($M) mpu6050: acc_x:$x, acc_y:$y, acc_z:$z

tuples | log.txt | m/s^2 | deg/s | .
> $S: acc=($x, $y, $z) gyro=($u, $v, $w)

JSON lines | log.txt | g | - | .
> {"ms": $M, "ax": $x, "ay": $y, "az": $z}

decimal commas | log.txt | g | - | ,
> ax=$x; ay=$y; az=$z

without gravity beside the total | - | m/s^2 | - | .
time_s,accelerometer_x,accelerometer_y,accelerometer_z,totalacceleration_x,totalacceleration_y,totalacceleration_z
> $S,0.01,0.02,0.03,$x,$y,$z

gravity beside the rest | - | g | - | .
timestamp,attitude_roll,gravity_x,gravity_y,gravity_z,user_acc_x,user_acc_y,user_acc_z
> $S,0.1,$x,$y,$z,0.00000,0.00000,0.00000

dead sensor first | - | g | - | .
time_ms,imu1_ax,imu1_ay,imu1_az,imu2_ax,imu2_ay,imu2_az
> $M,0,0,0,$x,$y,$z

accelerometer by another name | - | m/s^2 | - | .
t_ms,ax,ay,az,frame_x,frame_y,frame_z
> $M,0,0,0,$x,$y,$z

states of a calibration | log.txt | g | deg/s | .
> Calibration: sys 3, gyro 3, accel 0, mag 3
> Accel X = $x, Y = $y, Z = $z, gx = $u, gy = $v, gz = $w

a letter for each sensor | log.txt | g | deg/s | .
> A:  t: +$S x: $x y: $y z: $z
> G:  t: +$S x: $u y: $v z: $w
> M:  t: +$S x: 12.5 y: -3.2 z: 40.1

semicolon at the end | - | m/s^2 | - | .
> 33,Sitting,$N,$x,$y,$z;

clock at the end | - | g | deg/s | .
> $x,$y,$z,$u,$v,$w,$M

steps behind a comment | - | m/s^2 | - | .
# X value, Y value, Z value, time diff in ms
> $x $y $z 40

rates of a body | - | g | deg/s | .
time_ms,ax,ay,az,p,q,r
> $M,$x,$y,$z,$u,$v,$w

rates in other languages | - | g | deg/s | .
time_ms,ax,ay,az,giro_x,giro_y,giro_z
> $M,$x,$y,$z,$u,$v,$w

JSON in lines | log.txt | g | deg/s | .
>   {
>     "ms": $M,
>     "acc_x": $x,
>     "acc_y": $y,
>     "acc_z": $z,
>     "gyr_x": $u,
>     "gyr_y": $v,
>     "gyr_z": $w
>   },

JSON in groups | log.txt | g | deg/s | .
>   {
>     "ms": $M,
>     "acc": {
>       "x": $x,
>       "y": $y,
>       "z": $z
>     },
>     "gyro": {
>       "x": $u,
>       "y": $v,
>       "z": $w
>     }
>   },

ros2 topic echo | log.txt | m/s^2 | rad/s | .
> header:
>   stamp:
>     sec: $A
>     nanosec: $B
>   frame_id: imu_link
> orientation:
>   x: 0.0
>   y: 0.0
>   z: 0.0
>   w: 1.0
> angular_velocity:
>   x: $u
>   y: $v
>   z: $w
> angular_velocity_covariance:
> $O
> linear_acceleration:
>   x: $x
>   y: $y
>   z: $z
> linear_acceleration_covariance:
> $O
> ---

rostopic echo | log.txt | m/s^2 | rad/s | .
> header:
>   seq: $k
>   stamp:
>     secs: $A
>     nsecs: $B
>   frame_id: "imu_link"
> angular_velocity:
>   x: $u
>   y: $v
>   z: $w
> angular_velocity_covariance: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
> linear_acceleration:
>   x: $x
>   y: $y
>   z: $z
> linear_acceleration_covariance: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
> ---

stamps on lines of their own | - | m/s^2 | - | .
> $S
> $x,$y,$z

one value a line | log.txt | g | - | .
> accX: $x
> accY: $y
> accZ: $z
> ---
"#;

/// Row `k` as `pattern` says.
fn filled(pattern: &str, accel: &str, gyro: &str, k: usize, row: &Row) -> String {
    let [x, y, z] = row.accel_g.map(|g| match accel {
        "m/s^2" => format!("{:.5}", g * G),
        "g" => format!("{g:.5}"),
        "mg" => format!("{:08.2}", 1000.0 * g),
        counts => format!("{:.0}", g * counts.parse::<f64>().unwrap()),
    });
    let [u, v, w] = row.gyro_deg_s.map(|rate| match gyro {
        "rad/s" => format!("{:.5}", rate.to_radians()),
        "deg/s" | "-" => format!("{rate:.3}"),
        counts => format!("{:.0}", rate * counts.parse::<f64>().unwrap()),
    });
    let (s, ms) = (k as f64 / RATE_HZ, 40 * k as u64);
    let values = [
        ("$O", ["- 0.0"; 9].join("\n")),
        ("$X", format!("{x:>10}")),
        ("$Y", format!("{y:>10}")),
        ("$Z", format!("{z:>10}")),
        ("$x", x),
        ("$y", y),
        ("$z", z),
        ("$u", u),
        ("$v", v),
        ("$w", w),
        ("$k", k.to_string()),
        ("$S", format!("{s:.3}")),
        ("$T", format!("{s:06.3}")),
        ("$P", format!("{:02}:{:04}", ms / 1000, ms % 1000 * 10)),
        ("$M", ms.to_string()),
        ("$U", (1000 * ms).to_string()),
        ("$E", (1_600_000_000_000 + ms).to_string()),
        ("$N", ((1_600_000_000_000 + ms) * 1_000_000).to_string()),
        ("$A", (1_600_000_000 + ms / 1000).to_string()),
        ("$B", (ms % 1000 * 1_000_000).to_string()),
    ];
    let fill = |text: String, (token, value): &(&str, String)| text.replace(token, value);
    values.iter().fold(pattern.to_owned(), fill) + "\n"
}

#[test]
fn loggers_and_apps_are_read_without_options() {
    let rows = six_faces(4);
    for shape in SHAPES.replace('→', "\t").trim().split("\n\n") {
        let (names, lines) = shape.split_once('\n').unwrap();
        let [name, file_name, accel, gyro, decimal] = names.split(" | ").collect::<Vec<_>>()[..]
        else {
            panic!("{names}")
        };
        let (pattern, mut header): (Vec<&str>, Vec<&str>) =
            lines.lines().partition(|line| line.starts_with('>'));
        let pattern: Vec<&str> = pattern.iter().map(|l| l.get(2..).unwrap_or("")).collect();
        let pattern = pattern.join("\n");
        if file_name == "log.txt" {
            header = vec!["Starting sensor...", "Found it!"];
        }
        let mut text: String = header.iter().map(|line| format!("{line}\n")).collect();
        for (k, row) in rows.iter().enumerate() {
            text += &filled(&pattern, accel, gyro, k, row).replace('.', decimal);
        }
        let recording = read(&text, file_name.trim_start_matches('-'));
        assert_eq!(recording.rows(), rows.len(), "{name}");
        let unit = recording.units.accel.unit.name();
        let is_counts = accel.parse::<f64>().is_ok();
        assert_eq!(unit, if is_counts { "counts" } else { accel }, "{name}");
        assert_eq!(recording.gyro.is_some(), gyro != "-", "{name}");
        let mut stamps = ["$S", "$T", "$P", "$M", "$U", "$E", "$N", "$A"].iter();
        let has_clock = stamps.any(|s| pattern.contains(s)) || name.starts_with("steps");
        let rate_hz = recording.clock.rate_hz();
        let is_right = has_rate(&recording, RATE_HZ) || rate_hz.is_none();
        let is_right = is_right && rate_hz.is_some() == has_clock;
        assert!(is_right, "{name}: {rate_hz:?}");
        let scale = recording.units.accel.nominal().unwrap().recip() / G;
        let tolerance = if accel == "2048" { 5e-4 } else { 1e-4 };
        for (k, row) in rows.iter().enumerate() {
            for axis in 0..3 {
                let value_g = recording.accel[axis][k] * scale;
                let is_it = is_near(value_g, row.accel_g[axis], tolerance);
                assert!(is_it, "{name}, row {k}: {value_g}");
            }
        }
    }
}

/// What stands beside an accelerometer is its angular rate only if it is the same in every pose.
#[test]
fn a_magnetic_field_and_a_magnitude_are_neither_rate_nor_temperature() {
    let rows = six_faces(4);
    let text = |beside: &dyn Fn(&Row) -> String| -> String {
        let line = |(k, r): (usize, &Row)| {
            filled("$M,$x,$y,$z", "g", "-", k, r).replace('\n', &format!(",{}\n", beside(r)))
        };
        rows.iter().enumerate().map(line).collect()
    };
    let field = text(&|r| {
        let [u, v, w] = r.gyro_deg_s;
        let [x, y, z] = r.accel_g.map(f64::round);
        let field = [40.0 * y + u, 30.0 * z + 9.0 + v, 35.0 * x + w];
        field.map(|v| format!("{v:.2}")).join(",")
    });
    let rates = text(&|r| r.gyro_deg_s.map(|w| format!("{w:.3}")).join(","));
    let norm = text(&|r| format!("{:.3}", r.accel_g.iter().map(|v| v * v).sum::<f64>().sqrt()));
    for (text, has_gyro) in [(&field, false), (&rates, true), (&norm, false)] {
        let recording = read(text, "desk.csv");
        assert_eq!(recording.gyro.is_some(), has_gyro, "{text:.80}");
        assert_eq!(recording.temperature_c, None);
        assert!(has_rate(&recording, RATE_HZ));
        assert_eq!(has(&recording, "columns-unread"), !has_gyro);
    }
}

/// A comment with as many parts as there are columns is no header if it names no sensor.
#[test]
fn a_comment_above_the_rows_is_no_header() {
    let row = |(k, r): (usize, &Row)| filled("$M,$x,$y,$z", "g", "-", k, r);
    let rows: String = six_faces(4).iter().enumerate().map(row).collect();
    for comment in [
        "# the lab, 2026-01-01, Anna",
        "# Uno, at 25 Hz, on the table, Anna",
    ] {
        let recording = read(&format!("{comment}\n{rows}"), "desk.csv");
        assert!(has_rate(&recording, RATE_HZ), "{:?}", recording.clock);
        assert_eq!(recording.units.accel.unit, AccelUnit::StandardGravity);
    }
}

#[test]
fn a_typographic_minus_between_words_is_a_sign() {
    let rows = six_faces(4);
    let row = |(k, r): (usize, &Row)| filled("t: $M x: $x y: $y z: $z", "g", "-", k, r);
    let text: String = rows.iter().enumerate().map(row).collect();
    let plain = read(&text, "log.txt");
    let typographic = read(&text.replace('-', "\u{2212}"), "log.txt");
    assert_eq!(typographic.accel, plain.accel);
}

/// Of a first row without measurements no cell is a name.
#[test]
fn a_first_row_without_measurements_leaves_the_header() {
    let row = |(k, r): (usize, &Row)| filled("$M,$z,$y,$x", "g", "-", k, r);
    let rows: String = six_faces(4).iter().enumerate().map(row).collect();
    let clean = read(&format!("t,az,ay,ax\n{rows}"), "desk.csv");
    for (first, is_row) in [
        ("-40,--,--,--", true),
        ("-40,NaN,NaN,NaN", true),
        ("-40,,,", true),
        ("init,init,init,init", false),
    ] {
        let recording = read(&format!("t,az,ay,ax\n{first}\n{rows}"), "desk.csv");
        assert_eq!(recording.format.names, clean.format.names, "{first}");
        let from = usize::from(is_row);
        assert_eq!(recording.accel[0][from..], clean.accel[0], "{first}");
    }
}

/// What is no clock is no column of steps either.
#[test]
fn stamps_that_are_no_clock_are_told_and_not_used() {
    let stamped = |header: &str, stamp: fn(usize) -> usize| {
        let row = |(k, r): (usize, &Row)| {
            filled("$x,$y,$z", "g", "-", k, r).replacen("", &format!("{},", stamp(k)), 1)
        };
        let rows: String = six_faces(4).iter().enumerate().map(row).collect();
        read(&format!("{header},ax,ay,az\n{rows}"), "desk.csv")
    };
    let out_of_order: fn(usize) -> usize = |k| 40 * (k ^ 1) + 1000;
    for (header, stamp, kind, has_rate) in [
        // … the last one first, standing still, milliseconds.
        ("ms", out_of_order, "bad-stamps", false),
        ("ms", |k| 1_000_000 - 40 * k, "frozen-time", false),
        ("ms", |_| 40, "frozen-time", false),
        ("t (s)", |k| 40 * k, "time-unit-assumed", true),
    ] {
        let recording = stamped(header, stamp);
        assert_eq!(recording.clock.rate_hz().is_some(), has_rate, "{kind:?}");
        assert!(has(&recording, kind), "{:?}", recording.findings);
    }
}

/// A pair of columns compared with each other one is 25 million comparisons a row.
#[test]
fn thousands_of_columns_are_read() {
    const SENSORS: usize = 1667;
    let names = |of: fn(usize, char) -> String| -> String {
        let sensor = |k: usize| ['x', 'y', 'z'].map(|axis| of(k, axis)).join(",");
        (0..SENSORS).map(sensor).collect::<Vec<_>>().join(",")
    };
    let rows: String = (0..20)
        .map(|row| {
            let values = (0..3 * SENSORS).map(|c| format!("{}.{}", c % 10, (row * 7 + c) % 10));
            values.collect::<Vec<_>>().join(",") + "\n"
        })
        .collect();
    for header in [
        names(|k, axis| format!("node{k}.acc.{axis}")),
        names(|k, _| format!("node{k}.acc")) + "\n" + &names(|_, axis| axis.to_string()),
    ] {
        let text = format!("{header}\n{rows}");
        let options = ReadOptions {
            sensor: Some("node1234".to_owned()),
            ..ReadOptions::default()
        };
        let recording = read_bytes(text.as_bytes(), "", &options).unwrap();
        assert_eq!(recording.accel.map(|axis| axis[0]), [2.2, 3.3, 4.4]);
    }
}
