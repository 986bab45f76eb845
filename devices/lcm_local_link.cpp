#include "devices/lcm_local_link.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <ifaddrs.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "devices/big_endian.h"
#include "devices/monotonic.h"
#include "sim/base/error.h"

namespace limberg {

namespace {

constexpr uint32_t kSmall = 0x4c433032;  // "LC02"
constexpr size_t kHeader = 8, kLongestChannel = 63, kLargestPacket = 65'536;
constexpr int kAtOnce = 64;  // packets per call

[[noreturn]] void refuse(const std::string& url, const std::string& why) {
  throw InputError("", 0, "LCM address \"" + url + "\" cannot be opened" + why);
}

}  // namespace

LcmLocalLink::LcmLocalLink(const std::string& url) : packet_(kLargestPacket) {
  constexpr std::string_view kScheme = "udpm://";
  const std::string where =
      url.substr(std::min(url.size(), kScheme.size()), url.find('?') - std::min(url.size(), kScheme.size()));
  const size_t colon = where.find(':');
  sockaddr_in group{};
  group.sin_family = AF_INET;
  int port = 7667;
  if (colon != std::string::npos) {
    const char* end = where.data() + where.size();
    if (const auto r = std::from_chars(where.data() + colon + 1, end, port);
        r.ec != std::errc() || r.ptr != end || port < 1 || port > 65'535)
      refuse(url, ": its port is none; expected 1 to 65535");
  }
  group.sin_port = htons(uint16_t(port));
  if (inet_pton(AF_INET, where.substr(0, colon).c_str(), &group.sin_addr) != 1 ||
      !IN_MULTICAST(ntohl(group.sin_addr.s_addr)))
    refuse(url, ": it is no multicast address; expected one as 239.255.76.67");
  fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int yes = 1, no = 0, room = 1 << 21;
  ip_mreq join{};
  join.imr_multiaddr = group.sin_addr;
  join.imr_interface.s_addr = htonl(INADDR_ANY);  // where the route leads, as publishers' packets go
  setsockopt(fd_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
  setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no);
  if (fd_ < 0 || ::bind(fd_, reinterpret_cast<const sockaddr*>(&group), sizeof group) != 0 ||
      setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join) != 0) {
    const std::string why = std::strerror(errno);
    if (fd_ >= 0) ::close(fd_);
    refuse(url, " (" + why + "); expected a multicast route, for instance after: ip route add 224.0.0.0/4 dev lo");
  }
  read_own_addresses();
}

LcmLocalLink::~LcmLocalLink() {
  if (fd_ >= 0) ::close(fd_);
}

void LcmLocalLink::read_own_addresses() {
  asked_ns_ = monotonic_ns();
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return;
  own_.clear();
  for (const ifaddrs* i = all; i; i = i->ifa_next)
    if (i->ifa_addr && i->ifa_addr->sa_family == AF_INET) {
      sockaddr_in a;
      std::memcpy(&a, i->ifa_addr, sizeof a);
      own_.push_back(a.sin_addr.s_addr);
    }
  freeifaddrs(all);
}

bool LcmLocalLink::is_own(in_addr address) {
  if ((ntohl(address.s_addr) >> 24) == 127) return true;
  const auto known = [&] { return std::find(own_.begin(), own_.end(), address.s_addr) != own_.end(); };
  if (known()) return true;
  // An interface may have come up meanwhile; but a stranger does not make us ask for each of its packets.
  constexpr int64_t kSecondNs = 1'000'000'000;
  if (monotonic_ns() - asked_ns_ < kSecondNs) return false;
  read_own_addresses();
  return known();
}

bool LcmLocalLink::parse(const uint8_t* packet, size_t n, std::string_view& channel, const uint8_t*& data,
                         size_t& size) {
  if (n < kHeader + 1 || get_big_endian<uint32_t>(packet) != kSmall) return false;
  const auto* name = packet + kHeader;
  const auto* zero = static_cast<const uint8_t*>(std::memchr(name, 0, std::min(n - kHeader, kLongestChannel + 1)));
  if (!zero) return false;
  channel = {reinterpret_cast<const char*>(name), size_t(zero - name)};
  data = zero + 1;
  size = size_t(packet + n - data);
  return true;
}

bool LcmLocalLink::receive(int wait_ms, const Taker& take) {
  pollfd p{fd_, POLLIN, 0};
  const int ready = ::poll(&p, 1, wait_ms);
  if (ready < 0) return errno == EINTR;
  for (int i = 0; ready > 0 && i < kAtOnce; ++i) {
    sockaddr_in from{};
    socklen_t length = sizeof from;
    const ssize_t n = ::recvfrom(fd_, packet_.data(), packet_.size(), 0, reinterpret_cast<sockaddr*>(&from), &length);
    if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    if (!is_own(from.sin_addr)) {
      ++foreign_;
      continue;
    }
    std::string_view channel;
    const uint8_t* data = nullptr;
    size_t size = 0;
    if (parse(packet_.data(), size_t(n), channel, data, size)) take(channel, data, size);
  }
  return true;
}

}  // namespace limberg
