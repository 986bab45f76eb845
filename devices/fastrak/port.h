#pragma once
// The serial line, and a pseudo-terminal with the emulator at its other end.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "devices/fastrak/emulator.h"

namespace limberg::fastrak {

/// A serial port opened raw, 8N1, without waiting. Closed by the destructor.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort() { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// False, with why(): not there, not a terminal, no leave, a rate that it does not know.
  bool open(const std::string& path, int baud);
  void close();
  bool is_open() const { return fd_ >= 0; }
  /// Waits at most wait_ms for bytes. How many were read; -1 when the line is gone (unplugged).
  int read(uint8_t* bytes, size_t most, int wait_ms);
  /// False when the line is gone. What the line does not take within half a second is given up.
  bool write(const uint8_t* bytes, size_t n);
  const std::string& why() const { return why_; }

 private:
  int fd_ = -1;
  std::string why_;
};

/// Rates that the device knows (2400 to 115200).
bool known_baud(int baud);

/// An emulated FASTRAK on a pseudo-terminal, served by a thread of its own until destroyed.
class EmulatedPort {
 public:
  /// InputError: the system gives no pseudo-terminal.
  explicit EmulatedPort(Motion motion, const EmulatorSettings& settings = {});
  ~EmulatedPort();
  /// The path to open, as of a serial port.
  const std::string& path() const;
  /// Takes the line away (whoever has it open reads an error) and lays another; path() changes.
  void unplug();
  void plug_in();
  int64_t now_ns() const;  // the emulator's clock, which its motion follows: CLOCK_MONOTONIC since construction

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limberg::fastrak
