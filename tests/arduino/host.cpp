// Runs the sketch: host SECONDS START_US UNPLUG_S PLUG_S ADDRESS REGISTER=VALUE...   (numbers as C writes them)
// Afterwards the chip's registers are printed, one line "# REGISTER=VALUE" for each that is not zero.
#include <cstdlib>
#include <string>

#include "ravengc_imu.ino"

HostSerial Serial;
HostWire Wire;
static uint64_t now_us;

uint32_t micros() { return (uint32_t)(now_us += 20); }

int main(int count, char **words) {
  double seconds = std::atof(words[1]), unplug = std::atof(words[3]), plug = std::atof(words[4]);
  uint64_t start = now_us = std::strtoull(words[2], nullptr, 0);
  Wire.chip = (uint8_t)std::strtoul(words[5], nullptr, 0);
  for (int i = 6; i < count; i++) {
    char *value = nullptr;
    unsigned long number = std::strtoul(words[i], &value, 0);
    Wire.registers[number & 255] = (uint8_t)std::strtoul(value + 1, nullptr, 0);
  }
  setup();
  while (now_us - start < (uint64_t)(seconds * 1e6)) {
    double t = (now_us - start) * 1e-6;
    Wire.plugged = !(t >= unplug && t < plug);
    loop();
  }
  for (int i = 0; i < 256; i++)
    if (Wire.registers[i]) std::printf("# 0x%02X=0x%02X\n", i, Wire.registers[i]);
}
