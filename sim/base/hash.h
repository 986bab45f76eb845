#pragma once
// A 64-bit running hash (FNV-1a over bytes with a final mix) for states, scenes and topologies.
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>

namespace limberg {

class Hash64 {
 public:
  void bytes(const void* data, size_t n) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < n; ++i) h_ = (h_ ^ p[i]) * 0x100000001b3ull;
  }
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T v) {
    if constexpr (std::is_integral_v<T> && sizeof v == 4 && std::endian::native == std::endian::little) {
      // Two high bytes of zero only multiply: taken together, small numbers cost half.
      constexpr uint64_t p = 0x100000001b3ull;
      if (const auto u = uint32_t(v); u >> 16 == 0) {
        h_ = (h_ ^ (u & 0xff)) * p;
        h_ = (h_ ^ (u >> 8)) * (p * p * p);
        return;
      }
    }
    bytes(&v, sizeof v);
  }
  void add(const std::string& s) {
    add(uint64_t(s.size()));
    bytes(s.data(), s.size());
  }
  uint64_t value() const {
    uint64_t h = h_;
    h ^= h >> 33;
    h *= 0xff51afd7ed558ccdull;
    h ^= h >> 33;
    return h;
  }

 private:
  uint64_t h_ = 0xcbf29ce484222325ull;
};

}  // namespace limberg
