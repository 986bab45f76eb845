#pragma once
// Integers as LCM puts them into bytes.
#include <cstddef>
#include <cstdint>

namespace limberg {

template <class T>
T get_big_endian(const uint8_t* p) {
  uint64_t v = 0;
  for (size_t i = 0; i < sizeof(T); ++i) v = v << 8 | p[i];
  return T(v);
}

template <class T>
void put_big_endian(uint8_t* p, T value) {
  uint64_t v = uint64_t(value);
  for (size_t i = sizeof(T); i-- > 0; v >>= 8) p[i] = uint8_t(v);
}

}  // namespace limberg
