// An I2C bus with one chip on it, which is its registers, and which can be unplugged.
#pragma once
#include <cstdint>
#define WIRE_HAS_TIMEOUT

struct HostWire {
  uint8_t chip = 0;
  uint8_t registers[256] = {};
  bool plugged = true;

  void begin() {}
  void setClock(uint32_t) {}
  void setWireTimeout(uint32_t, bool) {}
  void beginTransmission(uint8_t address) { address_ = address, written_ = 0; }
  void write(uint8_t value) {
    if (written_++ == 0) pointer_ = value;
    else if (answers(address_)) registers[pointer_++] = value;
  }
  uint8_t endTransmission(bool = true) { return answers(address_) ? 0 : 2; }
  uint8_t requestFrom(uint8_t address, uint8_t count) { return answers(address) ? count : 0; }
  int read() { return registers[pointer_++]; }

 private:
  bool answers(uint8_t address) const { return plugged && address == chip; }
  uint8_t address_ = 0, pointer_ = 0;
  int written_ = 0;
};
extern HostWire Wire;
