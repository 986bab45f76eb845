#include "devices/fastrak/protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

#include "sim/base/elementary.h"

namespace limberg::fastrak {

namespace {

constexpr double kMmPerCm = 10;

bool is_letter(uint8_t c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

float get_float(const uint8_t* p) {
  return std::bit_cast<float>(uint32_t(p[0]) | uint32_t(p[1]) << 8 | uint32_t(p[2]) << 16 | uint32_t(p[3]) << 24);
}

void put_float(uint8_t* p, double v) {
  const auto u = std::bit_cast<uint32_t>(float(v));
  for (int i = 0; i < 4; ++i) p[i] = uint8_t(u >> (8 * i));
}

/// A field of seven characters with the point before the last `decimals`: blanks, a sign, digits. False: it is none.
bool get_fixed(const uint8_t* p, int decimals, double& v) {
  constexpr int width = 7;
  const int point = width - 1 - decimals;
  if (p[point] != '.') return false;
  int i = 0;
  while (i < point - 1 && p[i] == ' ') ++i;
  bool minus = false;
  if (i < point - 1 && (p[i] == '-' || p[i] == '+')) minus = p[i++] == '-';
  while (i < point - 1 && p[i] == ' ') ++i;  // "-  5.10" is sent as well
  int64_t digits = 0;
  for (; i < width; ++i) {
    if (i == point) continue;
    if (p[i] < '0' || p[i] > '9') return false;
    digits = 10 * digits + (p[i] - '0');
  }
  v = double(digits) * elementary::pow(10.0, -decimals);
  if (minus) v = -v;
  return true;
}

void put_fixed(uint8_t* p, int decimals, double v) {
  const double most = decimals == 2 ? 999.99 : 9.9999;
  const std::string text = fmt::format("{:7.{}f}", std::clamp(v, decimals == 2 ? -999.99 : -9.9999, most), decimals);
  std::memcpy(p, text.data(), 7);
}

}  // namespace

int Layout::active_count() const { return int(std::count(active.begin(), active.end(), true)); }

size_t encode(const Record& r, const Layout& layout, std::span<uint8_t, kLongest> out) {
  uint8_t* p = out.data();
  *p++ = '0';
  *p++ = uint8_t('0' + r.station);
  *p++ = uint8_t(r.error);
  for (int i = 0; i < 3; ++i) {
    if (layout.binary)
      put_float(p, r.pos_mm[i] / kMmPerCm), p += 4;
    else
      put_fixed(p, 2, r.pos_mm[i] / kMmPerCm), p += 7;
  }
  for (const double q : r.quat) {
    if (layout.binary)
      put_float(p, q), p += 4;
    else
      put_fixed(p, 4, q), p += 7;
  }
  if (layout.has_switch[size_t(r.station - 1)]) *p++ = ' ', *p++ = r.pressed ? '1' : '0';
  *p++ = '\r', *p++ = '\n';
  return size_t(p - out.data());
}

double accepted_share(const Record& r, const Layout& layout, double far_mm, double far_deg) {
  struct Take final : Parser::Sink {
    void on_record(const Record& record) override { got = record, any = true; }
    void on_reply(std::span<const char>) override {}
    Record got;
    bool any = false;
  };
  const auto read = [&](std::span<const uint8_t> bytes, Take& take) {
    Parser parser;
    parser.reset(layout);
    for (const uint8_t b : bytes) parser.feed(b, 0, take);
  };
  std::array<uint8_t, kLongest> bytes{};
  const size_t n = encode(r, layout, bytes);
  Take whole;
  read({bytes.data(), n}, whole);
  int64_t passed = 0;
  for (size_t i = 0; i < n; ++i) {
    const uint8_t right = bytes[i];
    for (int wrong = 0; wrong < 256; ++wrong) {
      if (wrong == right) continue;
      bytes[i] = uint8_t(wrong);
      Take take;
      read({bytes.data(), n}, take);
      if (!take.any) continue;
      const auto &a = take.got, &b = whole.got;
      double dot = 0;
      for (size_t k = 0; k < 4; ++k) dot += a.quat[k] * b.quat[k];
      const double moved = (a.pos_mm - b.pos_mm).norm(),
                   turned = 2 * elementary::acos(std::min(1.0, std::abs(dot))) * 180 / std::numbers::pi;
      const bool any = a.pos_mm != b.pos_mm || a.quat != b.quat || a.station != b.station || a.pressed != b.pressed;
      passed += far_mm > 0 || far_deg > 0 ? moved > far_mm || turned > far_deg : any;
    }
    bytes[i] = right;
  }
  return double(passed) / (255.0 * double(n));
}

void Parser::reset(const Layout& layout) {
  layout_ = layout;
  n_ = 0;
  before_[0] = '\r', before_[1] = '\n';
  in_step_ = true;
}

void Parser::drop(size_t n) {
  if (n == 0) return;
  before_[0] = n >= 2 ? byte_[n - 2] : before_[1];
  before_[1] = byte_[n - 1];
  std::memmove(byte_.data(), byte_.data() + n, n_ - n);
  std::memmove(t_ns_.data(), t_ns_.data() + n, (n_ - n) * sizeof t_ns_[0]);
  n_ -= n;
}

Parser::Look Parser::look_at_record(Record& r, size_t& length) const {
  if (n_ < 3) {
    if (n_ >= 2 && (byte_[1] < '1' || byte_[1] > '0' + kStations || !layout_.active[size_t(byte_[1] - '1')]))
      return Look::no;
    return Look::more;
  }
  if (byte_[1] < '1' || byte_[1] > '0' + kStations || !layout_.active[size_t(byte_[1] - '1')]) return Look::no;
  if (byte_[2] != ' ' && !is_letter(byte_[2])) return Look::no;
  r.station = byte_[1] - '0';
  r.error = char(byte_[2]);
  length = layout_.record_bytes(r.station);
  if (n_ < length) return Look::more;
  if (byte_[length - 2] != '\r' || byte_[length - 1] != '\n') return Look::no;
  const bool has_switch = layout_.has_switch[size_t(r.station - 1)];
  if (has_switch && (byte_[length - 4] != ' ' || (byte_[length - 3] != '0' && byte_[length - 3] != '1')))
    return Look::no;
  r.pressed = has_switch && byte_[length - 3] == '1';
  const uint8_t* p = byte_.data() + 3;
  const size_t width = layout_.binary ? 4 : 7;
  for (int i = 0; i < 3; ++i, p += width) {
    double v = 0;
    if (layout_.binary)
      v = get_float(p);
    else if (!get_fixed(p, 2, v))
      return Look::no;
    r.pos_mm[i] = v * kMmPerCm;
    if (!(std::abs(r.pos_mm[i]) <= kReachMm)) return Look::no;
  }
  double qq = 0;
  for (size_t i = 0; i < 4; ++i, p += width) {
    double v = 0;
    if (layout_.binary)
      v = get_float(p);
    else if (!get_fixed(p, 4, v))
      return Look::no;
    if (!(std::abs(v) <= 1.01)) return Look::no;
    r.quat[i] = v;
    qq += v * v;
  }
  if (!(qq >= 0.99 * 0.99 && qq <= 1.01 * 1.01)) return Look::no;
  const double scale = 1 / std::sqrt(qq);
  for (double& q : r.quat) q *= scale;
  r.t_ns = t_ns_[0];
  return Look::record;
}

Parser::Look Parser::look_at_reply(size_t& length) const {
  for (size_t i = 1; i < n_; ++i) {
    if (byte_[i] == '\n') {
      length = i + 1;
      return i >= 4 && byte_[i - 1] == '\r' ? Look::reply : Look::no;
    }
    const bool ends = byte_[i] == '\r' && (i + 1 == n_ || byte_[i + 1] == '\n');
    if (!ends && (byte_[i] < 0x20 || byte_[i] > 0x7E)) return Look::no;
    if (i == 1 && byte_[i] != ' ' && (byte_[i] < '0' || byte_[i] > '0' + kStations)) return Look::no;
    if (i == 2 && !is_letter(byte_[i])) return Look::no;
  }
  return n_ < kLongest ? Look::more : Look::no;
}

Parser::Look Parser::look(Record& record, size_t& length) const {
  if (before_[0] != '\r' || before_[1] != '\n') return Look::no;
  if (byte_[0] == '0') return look_at_record(record, length);
  if (byte_[0] == '2') return look_at_reply(length);
  return Look::no;
}

void Parser::feed(uint8_t byte, int64_t t_ns, Sink& sink) {
  ++counts_.bytes;
  byte_[n_] = byte;
  t_ns_[n_++] = t_ns;
  while (n_ > 0) {
    Record record;
    size_t length = 0;
    switch (look(record, length)) {
      case Look::more:
        return;
      case Look::no:
        if (in_step_) ++counts_.damaged;
        in_step_ = false;
        ++counts_.skipped_bytes;
        drop(1);
        break;
      case Look::record:
        drop(length);
        in_step_ = true;
        ++counts_.records;
        counts_.errors += record.error != ' ';
        sink.on_record(record);
        break;
      case Look::reply: {
        std::array<char, kLongest> text{};
        std::memcpy(text.data(), byte_.data(), length - 2);
        drop(length);
        in_step_ = true;
        ++counts_.replies;
        sink.on_reply({text.data(), length - 2});
        break;
      }
    }
  }
}

}  // namespace limberg::fastrak
