#pragma once
// A multicast address that no other program of this machine listens at. Ports computed from a process's number met:
// two tests that ctest starts side by side heard each other's packets.
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace limberg {

/// A UDP port of this machine that is free now, chosen by the system (by chance, so that two who ask at once hardly
/// ever get the same). std::runtime_error: none is to be had.
inline int free_udp_port() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  socklen_t size = sizeof any;
  auto* address = reinterpret_cast<sockaddr*>(&any);
  const bool bound = fd >= 0 && bind(fd, address, size) == 0 && getsockname(fd, address, &size) == 0;
  if (fd >= 0) close(fd);
  if (!bound) throw std::runtime_error("no free UDP port on this machine");
  return ntohs(any.sin_port);
}

/// LCM's address of that port, for this machine only.
inline std::string udpm_here(int port) { return "udpm://239.255.76.67:" + std::to_string(port) + "?ttl=0"; }

}  // namespace limberg
