// As much of an Arduino as the sketch uses, on the host: what it sends goes to standard output, time is counted.
#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>

uint32_t micros();

struct HostSerial {
  void begin(uint32_t) {}
  void print(const char *text) { std::fputs(text, stdout); }
  void write(const uint8_t *bytes, size_t count) { std::fwrite(bytes, 1, count, stdout); }
};
extern HostSerial Serial;
