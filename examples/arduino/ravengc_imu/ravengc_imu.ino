/* ravengc_imu: an accelerometer on I2C, sent 100 times a second, for `ravengc run --sensor serial:...?format=line`.
 *
 * Finds a BMA180, an ADXL345 or an LSM6DS3/DS3TR-C/DSL/DSR/DSO by its identification register and sends
 *
 *     A,<t_us>,ax,ay,az[,gx,gy,gz]*XX
 *
 * at 115200 baud: t_us is micros(), wrapping; specific force in m/s^2 (+9.81 along the axis that points up, at rest);
 * angular velocity in rad/s from sensors that have a gyroscope; XX is the exclusive or of the bytes before the star.
 * Lines that begin with '#' are for people. While the sensor cannot be read nothing is sent: a missing sample is an
 * alarm at the host, a repeated one would be a lie.
 *
 * Needs no library but Wire. With OUTPUT_ROSSERIAL 1 it speaks rosserial instead (library "Rosserial Arduino Library")
 * and publishes geometry_msgs/Vector3 on "accelerometer": `serial:...?format=rosserial`, at 57600 baud.
 *
 * Register addresses and sensitivities: data sheets of Bosch BMA180 (rev. 2.5), Analog Devices ADXL345 (rev. G), ST
 * LSM6DS3, LSM6DSL, LSM6DSO.
 */
#include <Arduino.h>
#include <Wire.h>

#ifndef OUTPUT_ROSSERIAL
#define OUTPUT_ROSSERIAL 0
#endif

#if OUTPUT_ROSSERIAL
#include <ros.h>
#include <geometry_msgs/Vector3.h>
#endif

const uint32_t PERIOD_US = 10000;
const uint32_t BAUD = 115200;
const uint8_t MOST_FAILURES = 10; /* then the sensor is looked for anew */
const float GRAVITY = 9.80665;
const float RADIANS_PER_DEGREE = 0.017453293;

struct Reading {
  int16_t force[3];
  int16_t rate[3];
};

struct Kind {
  const char *name;
  uint8_t addresses[2];
  uint8_t identity_register;
  uint8_t identities[4]; /* ends with 0 */
  bool (*start)(uint8_t address);
  bool (*read)(uint8_t address, Reading *reading);
  float force_scale; /* m/s^2 per count */
  float rate_scale;  /* rad/s per count, 0 without a gyroscope */
};

/* I2C */

bool write_register(uint8_t address, uint8_t number, uint8_t value) {
  Wire.beginTransmission(address);
  Wire.write(number);
  Wire.write(value);
  return Wire.endTransmission() == 0;
}

bool read_registers(uint8_t address, uint8_t first, uint8_t *values, uint8_t count) {
  Wire.beginTransmission(address);
  Wire.write(first);
  if (Wire.endTransmission(false) != 0) return false;
  if (Wire.requestFrom(address, count) != count) return false;
  for (uint8_t i = 0; i < count; i++) values[i] = Wire.read();
  return true;
}

bool change_register(uint8_t address, uint8_t number, uint8_t mask, uint8_t bits) {
  uint8_t value;
  return read_registers(address, number, &value, 1) && write_register(address, number, (value & ~mask) | bits);
}

int16_t word_at(const uint8_t *low_then_high) { return (int16_t)(low_then_high[0] | (uint16_t)low_then_high[1] << 8); }

/* BMA180: 14 bits at the upper end of each word, +-2 g, low-pass 40 Hz */

bool start_bma180(uint8_t address) {
  return change_register(address, 0x0D, 0x10, 0x10)     /* ctrl_reg0: registers may be written */
         && change_register(address, 0x20, 0xF0, 0x20)  /* bw_tcs: 40 Hz */
         && change_register(address, 0x35, 0x0E, 0x04); /* offset_lsb1: range 2 g */
}

bool read_bma180(uint8_t address, Reading *reading) {
  uint8_t bytes[6];
  if (!read_registers(address, 0x02, bytes, 6)) return false;
  for (uint8_t i = 0; i < 3; i++) reading->force[i] = (int16_t)(word_at(bytes + 2 * i) & ~3) / 4;
  return true;
}

/* ADXL345: full resolution, +-4 g, 100 Hz (bandwidth 50 Hz) */

bool start_adxl345(uint8_t address) {
  return write_register(address, 0x2C, 0x0A)     /* BW_RATE: 100 Hz */
         && write_register(address, 0x31, 0x09)  /* DATA_FORMAT: FULL_RES, 4 g */
         && write_register(address, 0x2D, 0x08); /* POWER_CTL: measure */
}

bool read_adxl345(uint8_t address, Reading *reading) {
  uint8_t bytes[6];
  if (!read_registers(address, 0x32, bytes, 6)) return false;
  for (uint8_t i = 0; i < 3; i++) reading->force[i] = word_at(bytes + 2 * i);
  return true;
}

/* LSM6DS: +-4 g, 250 deg/s, 104 Hz */

bool start_lsm6ds(uint8_t address) {
  return write_register(address, 0x12, 0x44)     /* CTRL3_C: whole words, addresses count up */
         && write_register(address, 0x10, 0x48)  /* CTRL1_XL: 104 Hz, 4 g */
         && write_register(address, 0x11, 0x40); /* CTRL2_G: 104 Hz, 250 deg/s */
}

bool read_lsm6ds(uint8_t address, Reading *reading) {
  uint8_t bytes[12];
  if (!read_registers(address, 0x22, bytes, 12)) return false;
  for (uint8_t i = 0; i < 3; i++) reading->rate[i] = word_at(bytes + 2 * i);
  for (uint8_t i = 0; i < 3; i++) reading->force[i] = word_at(bytes + 6 + 2 * i);
  return true;
}

const Kind KINDS[] = {
    {"BMA180", {0x40, 0x41}, 0x00, {0x03, 0}, start_bma180, read_bma180, GRAVITY / 4096, 0},
    {"ADXL345", {0x53, 0x1D}, 0x00, {0xE5, 0}, start_adxl345, read_adxl345, GRAVITY / 256, 0},
    {"LSM6DS", {0x6A, 0x6B}, 0x0F, {0x69, 0x6A, 0x6B, 0x6C}, start_lsm6ds, read_lsm6ds, GRAVITY * 0.000122,
     RADIANS_PER_DEGREE * 0.00875},
};
const uint8_t KIND_COUNT = sizeof(KINDS) / sizeof(KINDS[0]);

const Kind *sensor = NULL;
uint8_t sensor_address = 0;
uint8_t failures = 0;
uint32_t next_us = 0;

bool has_identity(const Kind &kind, uint8_t address) {
  uint8_t found;
  if (!read_registers(address, kind.identity_register, &found, 1)) return false;
  for (uint8_t i = 0; i < sizeof(kind.identities) && kind.identities[i] != 0; i++)
    if (kind.identities[i] == found) return true;
  return false;
}

bool find_sensor() {
  for (uint8_t i = 0; i < 2 * KIND_COUNT; i++) {
    const Kind &kind = KINDS[i / 2];
    uint8_t address = kind.addresses[i % 2];
    if (has_identity(kind, address) && kind.start(address)) {
      sensor = &kind;
      sensor_address = address;
      failures = 0;
      return true;
    }
  }
  return false;
}

/* Output */

#if OUTPUT_ROSSERIAL

ros::NodeHandle node;
geometry_msgs::Vector3 message;
ros::Publisher publisher("accelerometer", &message);

void begin_output() {
  node.initNode();
  node.advertise(publisher);
}

void tell(const char *text) { node.loginfo(text); }

void send(uint32_t, const Reading &reading) {
  message.x = sensor->force_scale * reading.force[0];
  message.y = sensor->force_scale * reading.force[1];
  message.z = sensor->force_scale * reading.force[2];
  publisher.publish(&message);
}

void serve() { node.spinOnce(); }

#else

char line[96];
uint8_t length;

void begin_output() { Serial.begin(BAUD); }

void tell(const char *text) {
  Serial.print("# ");
  Serial.print(text);
  Serial.print("\r\n");
}

void put(char character) {
  if (length < sizeof(line)) line[length++] = character;
}

void put_whole(uint32_t number) {
  char digits[10];
  uint8_t count = 0;
  do {
    digits[count++] = '0' + number % 10;
    number /= 10;
  } while (number != 0);
  while (count != 0) put(digits[--count]);
}

/* A comma and a number with four decimals. */
void put_decimal(float value) {
  put(',');
  if (value < 0) put('-');
  uint32_t scaled = (uint32_t)(fabs(value) * 10000.0 + 0.5);
  put_whole(scaled / 10000);
  put('.');
  for (uint32_t unit = 1000; unit != 0; unit /= 10) put('0' + scaled / unit % 10);
}

void send(uint32_t taken_us, const Reading &reading) {
  length = 0;
  put('A');
  put(',');
  put_whole(taken_us);
  for (uint8_t i = 0; i < 3; i++) put_decimal(sensor->force_scale * reading.force[i]);
  for (uint8_t i = 0; i < 3 && sensor->rate_scale != 0; i++) put_decimal(sensor->rate_scale * reading.rate[i]);
  uint8_t check = 0;
  for (uint8_t i = 0; i < length; i++) check ^= line[i];
  put('*');
  put("0123456789ABCDEF"[check >> 4]);
  put("0123456789ABCDEF"[check & 15]);
  put('\r');
  put('\n');
  Serial.write((const uint8_t *)line, length);
}

void serve() {}

#endif

void setup() {
  begin_output();
  Wire.begin();
  Wire.setClock(400000);
#ifdef WIRE_HAS_TIMEOUT
  Wire.setWireTimeout(3000, true); /* a sensor that holds the bus does not hold the board */
#endif
  next_us = micros();
}

void take_sample() {
  Reading reading;
  uint32_t taken_us = micros();
  if (sensor->read(sensor_address, &reading)) {
    failures = 0;
    send(taken_us, reading);
  } else if (++failures >= MOST_FAILURES) {
    sensor = NULL;
    tell("sensor lost");
  }
}

void loop() {
  serve();
  uint32_t late_us = micros() - next_us;
  if ((int32_t)late_us < 0) return;
  next_us += late_us < PERIOD_US ? PERIOD_US : late_us + PERIOD_US; /* skip what was missed */
  if (sensor != NULL) {
    take_sample();
  } else if (find_sensor()) {
    tell(sensor->name);
  } else {
    tell("no BMA180, ADXL345 or LSM6DS found: check power, SDA and SCL");
    next_us += 100 * PERIOD_US;
  }
}
