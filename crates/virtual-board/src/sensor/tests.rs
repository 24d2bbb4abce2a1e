use super::registers::*;
use super::*;

/// The counts of x name the sample: the time in milliseconds.
fn clock(time_s: f64) -> Reading {
    Reading {
        accel_mps2: [
            (time_s * 1e3).round() / 16384.0 * STANDARD_GRAVITY_MPS2,
            -STANDARD_GRAVITY_MPS2,
            3.0 * STANDARD_GRAVITY_MPS2,
        ],
        gyro_deg_s: [100.0, -200.0, 3000.0],
        temperature_c: 30.0,
    }
}

fn sensor(options: SensorOptions) -> Mpu6050 {
    Mpu6050::new(clock, options)
}

fn write(sensor: &mut Mpu6050, now_s: f64, register: u8, value: u8) -> bool {
    let taken = sensor.start(now_s, 0x68, false) && sensor.write(register) && sensor.write(value);
    sensor.stop();
    taken
}

fn read<const N: usize>(sensor: &mut Mpu6050, now_s: f64, register: u8) -> Option<[u8; N]> {
    let selected = sensor.start(now_s, 0x68, false)
        && sensor.write(register)
        && sensor.start(now_s, 0x68, true);
    let bytes = [(); N].map(|()| sensor.read());
    sensor.stop();
    selected.then_some(bytes)
}

fn words(bytes: [u8; 14]) -> [i16; 7] {
    [0, 1, 2, 3, 4, 5, 6].map(|i| i16::from_be_bytes([bytes[2 * i], bytes[2 * i + 1]]))
}

/// As the sketch sets it up, 100 Hz, at `now_s`.
fn awake(sensor: &mut Mpu6050, now_s: f64) {
    for (register, value) in [
        (PWR_MGMT_1, 1),
        (CONFIG, 3),
        (INT_ENABLE, 1),
        (SMPLRT_DIV, 9),
    ] {
        assert!(write(sensor, now_s, register, value));
    }
}

#[test]
fn asleep_at_power_up() {
    let mut sensor = sensor(SensorOptions::default());
    assert_eq!(read(&mut sensor, 0.1, WHO_AM_I), Some([0x68]));
    assert_eq!(read(&mut sensor, 0.1, PWR_MGMT_1), Some([SLEEP]));
    write(&mut sensor, 0.1, INT_ENABLE, 1);
    assert_eq!(read(&mut sensor, 9.0, INT_STATUS), Some([0]));
    assert_eq!(read(&mut sensor, 9.0, ACCEL_XOUT_H), Some([0; 14]));
    assert_eq!(sensor.samples(), (0, 0));
}

#[test]
fn data_ready_is_cleared_by_reading_the_status_only() {
    let mut sensor = sensor(SensorOptions::default());
    awake(&mut sensor, 1.0);
    assert_eq!(read(&mut sensor, 1.009, INT_STATUS), Some([0]));
    assert_eq!(
        read::<14>(&mut sensor, 1.0101, ACCEL_XOUT_H)
            .map(words)
            .unwrap()[0],
        1010
    );
    assert_eq!(read(&mut sensor, 1.0102, INT_STATUS), Some([1]));
    assert_eq!(read(&mut sensor, 1.0103, INT_STATUS), Some([0]));
    // Any read clears it when reported so.
    write(&mut sensor, 1.0104, INT_PIN_CFG, INT_RD_CLEAR);
    read::<14>(&mut sensor, 1.0201, ACCEL_XOUT_H).unwrap();
    assert_eq!(read(&mut sensor, 1.0202, INT_STATUS), Some([0]));
    // Without its enable bit there is none.
    write(&mut sensor, 1.021, INT_ENABLE, 0);
    assert_eq!(read(&mut sensor, 1.0301, INT_STATUS), Some([0]));
}

#[test]
fn a_burst_holds_one_sample_and_lost_ones_are_counted() {
    let mut sensor = sensor(SensorOptions::default());
    awake(&mut sensor, 0.0);
    assert!(sensor.start(0.0101, 0x68, false) && sensor.write(ACCEL_XOUT_H));
    assert!(sensor.start(0.0101, 0x68, true));
    let mut bytes = [0; 14];
    for (i, byte) in bytes.iter_mut().enumerate() {
        *byte = sensor.read();
        sensor.advance(0.0101 + 0.005 * i as f64);
    }
    assert_eq!(words(bytes)[0], 10);
    sensor.stop();
    let lost = sensor.samples().1;
    // Nothing for a second: 99 more, all but the last overwritten.
    assert!(sensor.start(1.0001, 0x68, false) && sensor.write(ACCEL_XOUT_H));
    assert!(sensor.start(1.0001, 0x68, true));
    bytes = [(); 14].map(|()| sensor.read());
    assert_eq!(words(bytes)[0], 1000);
    assert_eq!(sensor.samples(), (100, 99));
    assert!(lost < 99);
}

#[test]
fn ranges_and_clipping() {
    let mut sensor = sensor(SensorOptions::default());
    awake(&mut sensor, 0.0);
    for (code, one_g, three_g, rates) in [
        (0, -16384, i16::MAX, [13100, -26200]),
        (1, -8192, 24576, [6550, -13100]),
        (2, -4096, 12288, [3280, -6560]),
        (3, -2048, 6144, [1640, -3280]),
    ] {
        let now_s = f64::from(code) + 1.0;
        write(&mut sensor, now_s, ACCEL_CONFIG, code << 3);
        write(&mut sensor, now_s, GYRO_CONFIG, code << 3);
        let v = read(&mut sensor, now_s + 0.1, ACCEL_XOUT_H)
            .map(words)
            .unwrap();
        assert_eq!(v[1..3], [one_g, three_g], "range {code}");
        assert_eq!(v[3], ((30.0_f64 - 36.53) * 340.0).round() as i16);
        assert_eq!(v[4..6], rates, "range {code}");
        assert_eq!(v[6], i16::MAX);
    }
}

#[test]
fn rates_from_divider_and_low_pass() {
    for (config, divider, period_s) in [
        (3, 9, 0.01),
        (3, 0, 0.001),
        (6, 255, 0.256),
        (0, 9, 0.00125),
        (7, 0, 0.000_125),
    ] {
        let mut sensor = sensor(SensorOptions::default());
        awake(&mut sensor, 0.0);
        write(&mut sensor, 0.0, CONFIG, config);
        write(&mut sensor, 0.0, SMPLRT_DIV, divider);
        assert!((sensor.period_s() - period_s).abs() < 1e-12);
        sensor.advance(10.000_01);
        assert_eq!(
            sensor.samples().0,
            (10.000_01 / period_s) as u64,
            "{config} {divider}"
        );
    }
}

#[test]
fn its_clock_may_be_off() {
    let mut sensor = sensor(SensorOptions {
        clock_error_ppm: 10_000.0,
        ..SensorOptions::default()
    });
    awake(&mut sensor, 0.0);
    sensor.advance(100.001);
    assert_eq!(sensor.samples().0, 10_100);
}

#[test]
fn a_reset_takes_time_and_forgets_everything() {
    let mut sensor = sensor(SensorOptions::default());
    awake(&mut sensor, 0.0);
    assert!(write(&mut sensor, 1.0, PWR_MGMT_1, DEVICE_RESET));
    assert_eq!(read::<1>(&mut sensor, 1.005, WHO_AM_I), None, "busy");
    assert_eq!(read(&mut sensor, 1.1, PWR_MGMT_1), Some([SLEEP]));
    assert_eq!(read(&mut sensor, 1.1, SMPLRT_DIV), Some([0]));
}

#[test]
fn offset_registers_shift_the_readings() {
    let mut sensor = sensor(SensorOptions::default());
    awake(&mut sensor, 0.0);
    let [high, low] = read(&mut sensor, 0.5, XA_OFFS_H + 2).unwrap();
    let factory = i16::from_be_bytes([high, low]);
    let [high, low] = (factory + 204).to_be_bytes();
    write(&mut sensor, 0.5, XA_OFFS_H + 2, high);
    write(&mut sensor, 0.5, XA_OFFS_H + 3, low);
    let [high, low] = (-328_i16).to_be_bytes();
    write(&mut sensor, 0.5, XG_OFFS_H, high);
    write(&mut sensor, 0.5, XG_OFFS_H + 1, low);
    let v = read(&mut sensor, 1.0, ACCEL_XOUT_H).map(words).unwrap();
    assert_eq!(v[1], -16384 + 204 * 8, "204/2048 g");
    assert_eq!(v[4], 13100 - 1310, "10 deg/s less");
}

#[test]
fn what_cannot_be_written_and_where_nobody_is() {
    let mut sensor = sensor(SensorOptions::default());
    write(&mut sensor, 0.0, WHO_AM_I, 7);
    assert_eq!(read(&mut sensor, 0.0, WHO_AM_I), Some([0x68]));
    assert!(!sensor.start(0.0, 0x69, false));
    assert!(!sensor.write(1));
    assert_eq!(sensor.read(), 0xff);
    // The pointer goes round, and every register can be read.
    assert!(read::<200>(&mut sensor, 0.0, 0xff).is_some());
    let mut high = Mpu6050::new(
        clock,
        SensorOptions {
            address: 0x69,
            ..SensorOptions::default()
        },
    );
    assert!(high.start(0.0, 0x69, false));
}

#[test]
fn faults_on_their_schedule() {
    let mut sensor = sensor(SensorOptions {
        faults: "no-answer@1-2,who-am-i=0x70@3-4,frozen-x@5-6,dip@8"
            .parse()
            .unwrap(),
        ..SensorOptions::default()
    });
    sensor.restart(100.0);
    awake(&mut sensor, 100.0);
    assert!(read::<1>(&mut sensor, 100.9, WHO_AM_I).is_some());
    assert!(read::<1>(&mut sensor, 101.5, WHO_AM_I).is_none());
    assert_eq!(read(&mut sensor, 102.5, WHO_AM_I), Some([0x68]));
    assert_eq!(read(&mut sensor, 103.5, WHO_AM_I), Some([0x70]));
    let mut x = |now_s| read(&mut sensor, now_s, ACCEL_XOUT_H).map(words).unwrap()[0];
    assert_eq!(x(104.9951), 4990);
    assert_eq!((x(105.0051), x(105.5), x(105.9951)), (4990, 4990, 4990));
    assert_eq!(x(106.0151), 6010);
    assert_eq!(read(&mut sensor, 107.9, PWR_MGMT_1), Some([1]));
    assert_eq!(read(&mut sensor, 108.1, PWR_MGMT_1), Some([SLEEP]));
}
