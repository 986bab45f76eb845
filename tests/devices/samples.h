#pragma once
// Streams to test with: own generator, so that they are the same everywhere.
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "devices/sample.h"

namespace limberg::test {

struct Dice {  // splitmix64
  uint64_t state;
  uint64_t next() {
    uint64_t z = (state += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  size_t below(size_t n) { return size_t(next() % n); }
  double unit() { return double(next() >> 11) * 0x1p-53; }
  double normal() { return std::sqrt(-2 * std::log(1 - unit())) * std::cos(6.283185307179586 * unit()); }
};

inline StylusSample stylus(int64_t seq, int64_t t_ns, const Vec3& tip, bool pressed = false) {
  StylusSample s;
  s.device_id = 7;
  s.seq = seq;
  s.t_ns = t_ns;
  s.tip_mm = tip;
  s.quat = {0.8, 0.0, 0.6, 0.0};
  s.buttons = pressed ? 1 : 0;
  return s;
}

inline std::vector<Sample> stream(int n) {
  std::vector<Sample> out;
  for (int i = 0; i < n; ++i) {
    if (i % 50 == 10) {
      ControlSample c;
      c.device_id = 7;
      c.seq = i / 50;
      c.t_ns = int64_t(i) * 8'333'333;
      c.kind = i % 100 == 10 ? ControlSample::select_tool : ControlSample::stage;
      c.tool = Tool::scalpel;
      c.value = {4, 90, 4, double(i)};
      c.text = ShortText("flap cut");
      out.push_back(c);
    }
    out.push_back(stylus(i, int64_t(i) * 8'333'333, Vec3(0.1 * i, -3.5, std::sin(0.1 * i)), i % 20 > 10));
  }
  return out;
}

inline bool same(const Sample& a, const Sample& b) {
  if (a.index() != b.index()) return false;
  if (const auto* s = std::get_if<StylusSample>(&a)) {
    const auto& t = std::get<StylusSample>(b);
    return s->device_id == t.device_id && s->seq == t.seq && s->t_ns == t.t_ns && s->tip_mm == t.tip_mm &&
           s->quat == t.quat && s->buttons == t.buttons;
  }
  const auto &s = std::get<ControlSample>(a), &t = std::get<ControlSample>(b);
  return s.device_id == t.device_id && s.seq == t.seq && s.t_ns == t.t_ns && s.kind == t.kind && s.tool == t.tool &&
         s.value == t.value && s.text == t.text;
}

inline std::vector<uint8_t> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace limberg::test
