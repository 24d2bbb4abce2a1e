// gravical: logger for an MPU6050 on an Arduino Uno.
//
// Wiring: VCC to 5 V (modules with a regulator) or 3.3 V, GND to GND, SDA to A4,
// SCL to A5. Needs nothing but the bundled Wire library. 115200 baud.
//
// It prints a line that starts with '#' and says what it is and how it is set, a
// header with the true units, then one line a sample:
//
//   milliseconds, m/s^2 along x, y, z, degrees C, degrees/s about x, y, z
//
// A letter, a number and a line feed change the settings (see command()):
//
//   a2 a4 a8 a16         accelerometer: full scale in g
//   g250 g500 g1000 g2000  gyroscope: full scale in degrees/s
//   d184 d94 d44 d21 d10 d5  low-pass, Hz
//   r100                 samples a second, 4 to 250
//   f0 f1                SI units, counts
//   f3                   calibrated: m/s^2 and rad/s (see GRAVICAL_CALIBRATION)
//   p s                  pause, start again
//   ?                    say all of it again
//
// MIT or Apache 2.0, as you like.

#include <Wire.h>
#include <avr/wdt.h>

// ---- What you may want to change --------------------------------------------

const uint16_t ACCEL_RANGE_G = 2;        // 2, 4, 8 or 16
const uint16_t GYRO_RANGE_DEG_S = 500;   // 250, 500, 1000 or 2000
const uint16_t LOW_PASS_HZ = 44;         // 184, 94, 44, 21, 10 or 5; never off:
                                         // 260 Hz sampled at 100 Hz doubles the noise
const uint16_t RATE_HZ = 100;            // 4 to 250; without loss up to 150 in SI
                                         // units, 250 as counts

// Calibrated values: write a header beside this sketch,
//
//   gravical export cal.json --to arduino -o firmware/mpu6050_logger/mysensor.h --counts-per-g 16384 --counts-per-deg-s 65.5
//
// (counts of the ranges above: 8192, 4096, 2048 for 4, 8, 16 g; 131, 32.8, 16.4 for 250,
// 1000, 2000 degrees/s), and
// take away the two slashes. Raw values are still sent for f0, f1.
//#define GRAVICAL_CALIBRATION "mysensor.h"

#ifdef GRAVICAL_CALIBRATION
const uint8_t FORMAT = 3;                // calibrated
#else
const uint8_t FORMAT = 0;                // 0 SI units, 1 counts
#endif

static_assert(ACCEL_RANGE_G == 2 || ACCEL_RANGE_G == 4 || ACCEL_RANGE_G == 8
              || ACCEL_RANGE_G == 16, "ACCEL_RANGE_G: 2, 4, 8 or 16");
static_assert(GYRO_RANGE_DEG_S == 250 || GYRO_RANGE_DEG_S == 500 || GYRO_RANGE_DEG_S == 1000
              || GYRO_RANGE_DEG_S == 2000, "GYRO_RANGE_DEG_S: 250, 500, 1000 or 2000");
static_assert(LOW_PASS_HZ == 184 || LOW_PASS_HZ == 94 || LOW_PASS_HZ == 44 || LOW_PASS_HZ == 21
              || LOW_PASS_HZ == 10 || LOW_PASS_HZ == 5, "LOW_PASS_HZ: 184, 94, 44, 21, 10 or 5");
static_assert(RATE_HZ >= 4 && RATE_HZ <= 250, "RATE_HZ: 4 to 250");
static_assert(FORMAT <= 3 && FORMAT != 2, "FORMAT: 0, 1 or 3");

#ifdef GRAVICAL_CALIBRATION
#include GRAVICAL_CALIBRATION
#if !defined(GRAVICAL_ACCEL_COUNTS_PER_G) \
    || (defined(GRAVICAL_GYRO) && !defined(GRAVICAL_GYRO_COUNTS_PER_DEG_S))
#error "The header is not for the counts of the sensor. Export it without --name, with --counts-per-g 16384 (range 2 g; 8192, 4096, 2048: 4, 8, 16 g) and --counts-per-deg-s 65.5 (500 deg/s; 131, 32.8, 16.4: 250, 1000, 2000)"
#endif
// The data sheet rounds its sensitivities, hence the margin.
constexpr bool near(double is, double wanted) {
  return is > 0.99 * wanted && is < 1.01 * wanted;
}
static_assert(near(GRAVICAL_ACCEL_COUNTS_PER_G * ACCEL_RANGE_G, 32768),
              "ACCEL_RANGE_G is not the range of the header: export it with another --counts-per-g");
#ifdef GRAVICAL_GYRO
static_assert(near(GRAVICAL_GYRO_COUNTS_PER_DEG_S * GYRO_RANGE_DEG_S, 32750),
              "GYRO_RANGE_DEG_S is not the range of the header: export it with another --counts-per-deg-s");
#endif
#endif

// ---- The sensor -------------------------------------------------------------

const uint8_t WHO_AM_I_MPU6050 = 0x68;

const uint8_t SMPLRT_DIV = 0x19;
const uint8_t CONFIG = 0x1A;
const uint8_t GYRO_CONFIG = 0x1B;
const uint8_t ACCEL_CONFIG = 0x1C;
const uint8_t ACCEL_CONFIG_2 = 0x1D;    // MPU-6500: low-pass of the accelerometer
const uint8_t INT_ENABLE = 0x38;
const uint8_t INT_STATUS = 0x3A;
const uint8_t ACCEL_XOUT_H = 0x3B;
const uint8_t PWR_MGMT_1 = 0x6B;
const uint8_t WHO_AM_I = 0x75;

const uint16_t LOW_PASSES_HZ[] = {184, 94, 44, 21, 10, 5};  // by their codes, from 1

// A look at the sensor and the next one are less than this apart.
const uint32_t ONE_TURN_US = 400;

const uint32_t BAUD = 115200;

// Types stand before the first function: the IDE puts its prototypes there.
struct Settings {
  uint16_t accelRangeG;
  uint16_t gyroRangeDegS;
  uint16_t lowPassHz;
  uint16_t rateHz;
  uint8_t format;
};

Settings settings = {ACCEL_RANGE_G, GYRO_RANGE_DEG_S, LOW_PASS_HZ, RATE_HZ, FORMAT};

// What went wrong since the start. Said in a line when it grows.
struct Counters {
  uint32_t overruns;   // samples that were overwritten before they were read
  uint32_t i2cErrors;  // transfers that failed
  uint16_t restarts;   // times the sensor was set up again
};

Counters counters = {0, 0, 0};
Counters reported = {0, 0, 0};

uint8_t address = 0x68;   // 0x69 with AD0 high
uint8_t whoAmI = WHO_AM_I_MPU6050;
bool running = false;     // the sensor answers and is set up
bool paused = false;
uint32_t periodUs = 10000;
uint64_t lastReadyUs = 0;
uint64_t lastLookUs = 0;  // when there was no sample yet
uint64_t dueUs = 0;       // when the last sample was ready
uint32_t lastNoticeMs = 0;
uint32_t nextTryMs = 0;   // when to look for the sensor again
bool first = true;        // no sample yet since the last set-up

// The watchdog barks before it bites: its interrupt leaves a mark here, the
// second time it resets. The reset flags would not do, the boot loader of the Uno
// clears them before the sketch starts.
const uint16_t HUNG = 0x5AA5;
volatile uint16_t hung __attribute__((section(".noinit")));

ISR(WDT_vect) {
  hung = HUNG;
}

void armWatchdog() {
  wdt_enable(WDTO_1S);
  WDTCSR |= _BV(WDIE);
}

void stopWatchdog() __attribute__((naked, used, section(".init3")));
void stopWatchdog() {
  MCUSR = 0;
  wdt_disable();  // it stays on through a reset, at its shortest
}

// Microseconds since the start. Every turn of the loop asks: micros() begins again after 71 minutes.
uint64_t microseconds() {
  static uint64_t total = 0;
  static uint32_t before = 0;
  const uint32_t now = micros();
  total += (uint32_t)(now - before);
  before = now;
  return total;
}

// ---- I2C --------------------------------------------------------------------

void startBus() {
  Wire.begin();
  Wire.setClock(400000);
  Wire.setWireTimeout(3000, true);  // a stuck bus is given up, not waited for
}

bool writeRegister(uint8_t reg, uint8_t value) {
  Wire.beginTransmission(address);
  Wire.write(reg);
  Wire.write(value);
  if (Wire.endTransmission() == 0) return true;
  counters.i2cErrors++;
  return false;
}

bool readRegisters(uint8_t reg, uint8_t *into, uint8_t count) {
  Wire.beginTransmission(address);
  Wire.write(reg);
  if (Wire.endTransmission(false) == 0 && Wire.requestFrom(address, count) == count) {
    for (uint8_t i = 0; i < count; i++) into[i] = Wire.read();
    return true;
  }
  counters.i2cErrors++;
  while (Wire.available()) Wire.read();
  return false;
}

// A sensor that was cut off in the middle of a byte holds the data line until it
// has got rid of it: nine clocks at most (UM10204, 3.1.16).
void freeBus() {
  if (digitalRead(SDA)) return;
  Wire.end();
  for (uint8_t i = 0; i < 9 && !digitalRead(SDA); i++) {
    pinMode(SCL, OUTPUT);  // low: Wire.end() left it so
    delayMicroseconds(5);
    pinMode(SCL, INPUT);
    delayMicroseconds(5);
  }
  startBus();
}

// ---- Setting up -------------------------------------------------------------

uint8_t rangeCode(uint16_t value, uint16_t smallest) {
  uint8_t code = 0;
  while (code < 3 && (smallest << code) < value) code++;
  return code;
}

uint8_t lowPassCode(uint16_t hz) {
  uint8_t code = 1;
  while (code < 6 && hz < LOW_PASSES_HZ[code - 1]) code++;
  return code;
}

// Once a second at most: whoever reads along must not drown.
bool noticeDue() {
  if (lastNoticeMs != 0 && millis() - lastNoticeMs < 1000) return false;
  lastNoticeMs = millis() | 1;
  return true;
}

// MPU-6500 (0x70), MPU-9250 (0x71), MPU-9255 (0x73), MPU-6515 (0x74) and their clones.
bool isMpu6500(uint8_t id) { return id >= 0x70 && id <= 0x75; }

// Boards sold with an MPU6050 carry these, too. Other parts at the address are clocks.
bool isKnown(uint8_t id) {
  return id == WHO_AM_I_MPU6050 || id == 0x69 || id == 0x98 || isMpu6500(id);
}

void sayWho(uint8_t id, const __FlashStringHelper *what) {
  Serial.print(F("# who-am-i 0x"));
  Serial.print(id, HEX);
  Serial.print(what);
}

// Finds the sensor and sets it up; says what is the matter when it does not work.
bool setUp() {
  uint8_t id = 0;
  bool answers = false;
  const uint32_t errors = counters.i2cErrors;
  for (uint8_t a = 0x68; a <= 0x69 && !answers; a++) {
    address = a;
    answers = readRegisters(WHO_AM_I, &id, 1);
  }
  counters.i2cErrors = errors;  // asking who is there is no error
  if (!answers) {
    if (noticeDue()) {
      Serial.print(F("# no answer from a sensor at 0x68 or 0x69: check SDA (A4), SCL (A5), power\n"));
    }
    freeBus();
    return false;
  }
  if (!isKnown(id)) {
    if (noticeDue()) sayWho(id, F(": not an MPU6050 (0x68), nor a relative that is known\n"));
    return false;
  }
  whoAmI = id;
  const uint8_t divider = 1000 / settings.rateHz - 1;
  if (!writeRegister(PWR_MGMT_1, 0x80)) return false;  // all registers as after power-up
  delay(100);
  wdt_reset();
  const bool set = writeRegister(PWR_MGMT_1, 0x01)  // awake, clock of the x gyroscope
      && writeRegister(CONFIG, lowPassCode(settings.lowPassHz))
      && writeRegister(SMPLRT_DIV, divider)
      && writeRegister(GYRO_CONFIG, rangeCode(settings.gyroRangeDegS, 250) << 3)
      && writeRegister(ACCEL_CONFIG, rangeCode(settings.accelRangeG, 2) << 3)
      && (!isMpu6500(whoAmI)
          || writeRegister(ACCEL_CONFIG_2, lowPassCode(settings.lowPassHz)))
      && writeRegister(INT_ENABLE, 0x01);
  if (!set) return false;
  delay(30);  // the gyroscope's start; its low-pass has settled then
  uint8_t status;
  readRegisters(INT_STATUS, &status, 1);  // what was ready before is old
  periodUs = 1000UL * (divider + 1);
  first = true;
  lastReadyUs = microseconds();
  return true;
}

// ---- Text -------------------------------------------------------------------

// Appends value / 10^decimals: an eighth of the time that printing a float takes.
char *appendDigits(char *at, uint32_t value, uint8_t decimals) {
  char digits[11];
  uint8_t n = 0;
  do {
    digits[n++] = '0' + value % 10;
    value /= 10;
  } while (value > 0 || n <= decimals);
  while (n > 0) {
    if (n == decimals) *at++ = '.';
    *at++ = digits[--n];
  }
  return at;
}

char *appendFixed(char *at, int32_t value, uint8_t decimals) {
  if (value < 0) {
    *at++ = '-';
    value = -value;
  }
  return appendDigits(at, value, decimals);
}

// value * factor / 2^shift, rounded.
int32_t scaled(int16_t value, uint16_t factor, uint8_t shift) {
  return ((int32_t)value * factor + (1L << (shift - 1))) >> shift;
}

// What the sketch can calibrate: bits of the values, from 0.
#if defined(GRAVICAL_CALIBRATION) && defined(GRAVICAL_GYRO)
const uint8_t CALIBRATED = 0x77;
#elif defined(GRAVICAL_CALIBRATION)
const uint8_t CALIBRATED = 0x07;
#else
const uint8_t CALIBRATED = 0;
#endif

void printText(uint32_t ms, const int16_t *v) {
  char line[96];
  char *at = appendDigits(line, ms, 0);
  const uint8_t done = settings.format == 3 ? CALIBRATED : 0;
  float si[7] = {};  // m/s^2 and rad/s
#ifdef GRAVICAL_CALIBRATION
  if (done) gravical_apply(v, si);
#ifdef GRAVICAL_GYRO
  if (done) gravical_apply_gyro(v + 4, si, si + 4);
#endif
#endif
  const uint8_t a = rangeCode(settings.accelRangeG, 2);
  const uint8_t g = rangeCode(settings.gyroRangeDegS, 250);
  for (uint8_t i = 0; i < 7; i++) {
    *at++ = ',';
    if (settings.format == 1) {
      at = appendFixed(at, v[i], 0);
    } else if (done & (1 << i)) {
      at = appendFixed(at, lround(si[i] * 1e5f), 5);
    } else if (i < 3) {
      // 9.80665 m/s^2 / 16384 in 10^-4 m/s^2, times 2^13; twice that each range.
      at = appendFixed(at, scaled(v[i], 49033, 13 - a), 4);
    } else if (i == 3) {
      // In 10^-2 degrees: 1/340 each, 36.53 at 0; MPU-6500 1/333.87 each, 21 at 0.
      at = isMpu6500(whoAmI) ? appendFixed(at, scaled(v[i], 19629, 16) + 2100, 2)
                             : appendFixed(at, scaled(v[i], 19275, 16) + 3653, 2);
    } else {
      // 1/131 degrees/s in 10^-3, times 2^12; the data sheet rounds 131/4 and 131/8 to 32.8 and
      // 16.4.
      at = appendFixed(at, scaled(v[i], g < 2 ? 31267 : 31220, 12 - g), 3);
    }
  }
  *at++ = '\n';
  Serial.write((const uint8_t *)line, at - line);
}

// ---- What it says of itself -------------------------------------------------

void printSettings() {
  const bool isCalibrated = settings.format == 3;
  if (whoAmI != WHO_AM_I_MPU6050) {
    sayWho(whoAmI, isMpu6500(whoAmI)
        ? F(": MPU-6500 or a clone; temperature and low-pass as for one\n")
        : F(": not an MPU6050 (0x68), used as one\n"));
  }
  Serial.print(F("# gravical mpu6050_logger 1.1, MPU6"));
  Serial.print(isMpu6500(whoAmI) ? F("500, accelerometer +-") : F("050, accelerometer +-"));
  Serial.print(settings.accelRangeG);
  Serial.print(F(" g, gyroscope +-"));
  Serial.print(settings.gyroRangeDegS);
  Serial.print(F(" deg/s, low-pass "));
  Serial.print(settings.lowPassHz);
  Serial.print(F(" Hz, rate "));
  char rate[12];
  *appendFixed(rate, 100000000UL / periodUs, 2) = 0;
  Serial.print(rate);
  Serial.print(F(" Hz, format "));
  Serial.print(settings.format);
#ifdef GRAVICAL_CALIBRATION
  if (isCalibrated) Serial.print(F(", calibrated " GRAVICAL_CREATED));
#endif
  Serial.print(F("\nTimestamp (ms),"));
  // Calibrated columns have the names that `gravical apply` gives them.
  Serial.print(settings.format == 1 ? F("ax,ay,az,temp,")
               : isCalibrated       ? F("ax_mps2,ay_mps2,az_mps2,Temp (C),")
                                    : F("aX (m/s^2),aY (m/s^2),aZ (m/s^2),Temp (C),"));
  Serial.print(settings.format == 1                   ? F("gx,gy,gz\n")
               : isCalibrated && (CALIBRATED & 0x70) ? F("gx_rad_s,gy_rad_s,gz_rad_s\n")
                                                      : F("gX (deg/s),gY (deg/s),gZ (deg/s)\n"));
}

void tellCounters() {
  if (memcmp(&counters, &reported, sizeof counters) == 0 || !noticeDue()) return;
  reported = counters;
  Serial.print(F("# overruns "));
  Serial.print(counters.overruns);
  Serial.print(F(", i2c errors "));
  Serial.print(counters.i2cErrors);
  Serial.print(F(", restarts "));
  Serial.print(counters.restarts);
  Serial.print('\n');
}

// ---- Commands ---------------------------------------------------------------

// A calibration is for the ranges of its header.
bool isCalibratedFor(const Settings &wanted) {
  return CALIBRATED && wanted.accelRangeG == ACCEL_RANGE_G
      && (!(CALIBRATED & 0x70) || wanted.gyroRangeDegS == GYRO_RANGE_DEG_S);
}

void command(char letter, uint16_t number) {
  Settings wanted = settings;
  switch (letter) {
    case 'a': wanted.accelRangeG = 2 << rangeCode(number, 2); break;
    case 'g': wanted.gyroRangeDegS = 250 << rangeCode(number, 250); break;
    case 'd': wanted.lowPassHz = LOW_PASSES_HZ[lowPassCode(number) - 1]; break;
    case 'r': wanted.rateHz = constrain(number, 4, 250); break;
    case 'f': wanted.format = number == 1 || number == 3 ? number : 0; break;
    case 'p': paused = true; return;
    case 's': paused = false; first = true; return;
    case '?':
      if (running) printSettings();
      return;
    default:
      Serial.print(F("# not a command: a g d r f with a number, p, s, ?\n"));
      return;
  }
  if (wanted.format == 3 && !isCalibratedFor(wanted)) {
    Serial.print(CALIBRATED ? F("# no calibration for this range: raw values, f0 f1, have all ranges\n")
                            : F("# no calibration in this sketch: f0 f1\n"));
    return;
  }
  settings = wanted;
  running = false;  // the loop sets the sensor up again, and says how
  nextTryMs = millis();
}

void listen() {
  static char letter = 0;
  static uint16_t number = 0;
  while (Serial.available()) {
    const char c = Serial.read();
    if (c == '\n' || c == '\r') {
      if (letter) command(letter, number);
      letter = 0;
      number = 0;
    } else if (c >= '0' && c <= '9' && letter) {
      if (number < 6000) number = 10 * number + (c - '0');
    } else if (c != ' ') {
      letter = c;
      number = 0;
    }
  }
}

// ---- The loop ---------------------------------------------------------------

void lost() {
  running = false;
  nextTryMs = millis();
  counters.restarts++;
}

void setup() {
  armWatchdog();
  Serial.begin(BAUD);
  // What a reset tore off has its end here: the first line is not glued to half a row.
  Serial.write('\n');
  startBus();
  if (hung == HUNG) {
    Serial.print(F("# restarted by the watchdog: the program had hung\n"));
  }
  hung = 0;
}

void loop() {
  wdt_reset();
  if (hung == HUNG) {  // only slow
    hung = 0;
    WDTCSR |= _BV(WDIE);
  }
  listen();
  microseconds();
  if (!running) {
    if ((int32_t)(millis() - nextTryMs) < 0) return;
    running = setUp();
    if (running) printSettings();
    nextTryMs = millis() + 100;
    return;
  }
  // Status and sample in two transfers: what is read in one is the sample of its
  // start, and the status may be newer than that.
  uint8_t status = 0;
  if (!readRegisters(INT_STATUS, &status, 1)) {
    lost();
    return;
  }
  if (!(status & 0x01)) {
    lastLookUs = microseconds();
    // Asleep after a dip of its supply, it answers and has nothing to say.
    if (lastLookUs - lastReadyUs > 5 * periodUs + 50000UL) lost();
    tellCounters();
    return;
  }
  const uint64_t seen = microseconds();
  uint8_t bytes[14];
  if (!readRegisters(ACCEL_XOUT_H, bytes, sizeof bytes)) {
    lost();
    return;
  }
  const bool watched = seen - lastLookUs < ONE_TURN_US;
  if (first && !watched) {  // came while the settings were printed: when is not known
    lastReadyUs = seen;
    return;
  }
  // The moment of data-ready. Right after a look that found nothing it is now, to
  // one turn of this loop. Else it was before, by as much as we are late.
  dueUs += periodUs;
  const int32_t late = seen - dueUs;
  if (first || late < 0 || watched) {
    dueUs = seen;
  } else if (late > (int32_t)(periodUs - periodUs / 4)) {
    const uint32_t missed = (late + periodUs / 4) / periodUs;
    counters.overruns += missed;
    dueUs += missed * periodUs;
  }
  first = false;
  lastReadyUs = seen;
  if (paused) return;
  int16_t v[7];
  for (uint8_t i = 0; i < 7; i++) {
    v[i] = (int16_t)((uint16_t)bytes[2 * i] << 8 | bytes[2 * i + 1]);
  }
  printText(dueUs / 1000, v);
  tellCounters();
}
