#include "devices/fastrak/emulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <numbers>

#include "sim/base/elementary.h"
#include "sim/geometry/rotation.h"

namespace limberg::fastrak {

namespace {

constexpr double kMmPerInch = 25.4;
constexpr int64_t kReinitialiseNs = 10'000'000'000;

bool takes_arguments(char c) { return std::string_view("OlHAReNIQVrvxGoyTbB").find(c) != std::string_view::npos; }

/// The numbers behind the letter of a command.
std::vector<double> arguments(const std::string& text) {
  std::vector<double> v;
  for (size_t at = 1; at < text.size();) {
    const size_t comma = std::min(text.find(',', at), text.size());
    v.push_back(std::strtod(text.substr(at, comma - at).c_str(), nullptr));
    at = comma + 1;
  }
  return v;
}

void put_float(std::vector<uint8_t>& out, double v) {
  const auto u = std::bit_cast<uint32_t>(float(v));
  for (int i = 0; i < 4; ++i) out.push_back(uint8_t(u >> (8 * i)));
}
void put_text(std::vector<uint8_t>& out, int decimals, double v) {
  const std::string text = fmt::format("{:7.{}f}", v, decimals);
  out.insert(out.end(), text.begin(), text.end());
}

}  // namespace

Emulator::Emulator(Motion motion, const EmulatorSettings& settings)
    : motion_(std::move(motion)), set_(settings), random_(settings.seed) {
  power_on();
}

void Emulator::power_on() {
  layout_.binary = false;
  centimetres_ = continuous_ = stopped_ = false;
  line_.clear();
  for (size_t i = 0; i < size_t(kStations); ++i) {
    items_[i] = {2, 4, 1};
    hemisphere_[i] = Vec3::UnitX();
    layout_.active[i] = set_.plugged[i];
  }
}

void Emulator::answer(const std::string& text) {
  out_.insert(out_.end(), text.begin(), text.end());
  out_.push_back('\r'), out_.push_back('\n');
}

void Emulator::receive(const uint8_t* bytes, size_t n, int64_t now_ns) {
  for (size_t i = 0; i < n; ++i) {
    const char c = char(bytes[i]);
    if (now_ns < busy_until_ns_) continue;  // it does not listen while it starts
    if (c == 0x19) {
      power_on();
      busy_until_ns_ = now_ns + kReinitialiseNs;
    } else if (c == 0x13 || c == 0x11) {
      stopped_ = c == 0x13;
    } else if (!line_.empty()) {
      if (c == '\r') {
        command(line_, now_ns);
        line_.clear();
      } else if (c != '\n' && line_.size() < 254) {
        line_ += c;
      }
    } else if (takes_arguments(c)) {
      line_ = c;
    } else if (c > ' ') {
      command(std::string(1, c), now_ns);
    }
  }
}

void Emulator::command(const std::string& text, int64_t now_ns) {
  const std::vector<double> a = arguments(text);
  const int station = a.empty() || !(a[0] >= 1 && a[0] <= kStations) ? 0 : int(a[0]);
  const auto i = size_t(std::max(0, station - 1));
  switch (text[0]) {
    case 'S': {
      // 55 bytes with CR LF: station, states, version, identification
      const std::string status = fmt::format("21S{:<50.50}", "0000  Limberg emulated FASTRAK 1.0");
      answer(status);
      break;
    }
    case 'C':
      continuous_ = true;
      next_sample_ns_ = now_ns;
      break;
    case 'c':
      continuous_ = false;
      break;
    case 'F':
      layout_.binary = false;
      break;
    case 'f':
      layout_.binary = true;
      break;
    case 'U':
      centimetres_ = false;
      break;
    case 'u':
      centimetres_ = true;
      break;
    case 'P':
      for (int s = 1; s <= kStations; ++s)
        if (layout_.active[size_t(s - 1)]) record(s, now_ns);
      break;
    case 'O':
      if (station == 0 || a.size() < 2) break;
      items_[i].clear();
      for (size_t k = 1; k < a.size() && items_[i].size() < 32; ++k) items_[i].push_back(int(a[k]));
      layout_.has_switch[i] = std::find(items_[i].begin(), items_[i].end(), 16) != items_[i].end();
      break;
    case 'l':
      if (station == 0) break;
      if (a.size() >= 2) {
        layout_.active[i] = a[1] != 0 && set_.plugged[i];
      } else {
        std::string states = "2" + std::to_string(station) + "l";
        for (const bool on : layout_.active) states += on ? '1' : '0';
        answer(states);
      }
      break;
    case 'H':
      if (station != 0 && a.size() >= 4) hemisphere_[i] = Vec3(a[1], a[2], a[3]);
      break;
    default:
      break;  // filters, alignment, increments, the switch's function: taken and without effect here
  }
}

void Emulator::record(int station, int64_t sample_ns) {
  const auto i = size_t(station - 1);
  if (!set_.plugged[i]) return;
  const StationPose truth = motion_(station, double(sample_ns) * 1e-9);
  Record r;
  r.station = station;
  r.error = error_;
  const Vec3 noise = random_.normal3(), turn = random_.normal3();
  r.pos_mm = truth.pos_mm + set_.noise_mm * noise;
  if (hemisphere_[i].squaredNorm() > 0 && hemisphere_[i].dot(r.pos_mm) < 0) r.pos_mm = -r.pos_mm;
  const Eigen::Quaterniond q =
      (truth.orientation * Eigen::Quaterniond(1, 0.5 * set_.noise_rad * turn.x(), 0.5 * set_.noise_rad * turn.y(),
                                              0.5 * set_.noise_rad * turn.z()))
          .normalized();
  r.quat = {q.w(), q.x(), q.y(), q.z()};
  r.pressed = truth.pressed;
  r.t_ns = sample_ns;
  if (keep_sent) sent.push_back({r, sample_ns, truth.pos_mm});

  std::vector<uint8_t> b{'0', uint8_t('0' + station), uint8_t(r.error)};
  const double unit = centimetres_ ? 10 : kMmPerInch;
  const Vec3 angles = azimuth_elevation_roll(q.toRotationMatrix()) * 180 / std::numbers::pi;
  const auto numbers = [&](std::initializer_list<double> values, int decimals) {
    for (const double v : values) layout_.binary ? put_float(b, v) : put_text(b, decimals, v);
  };
  for (const int item : items_[i]) {
    switch (item) {
      case 0:
        b.push_back(' ');
        break;
      case 1:
        b.push_back('\r'), b.push_back('\n');
        break;
      case 2:
        numbers({r.pos_mm.x() / unit, r.pos_mm.y() / unit, r.pos_mm.z() / unit}, 2);
        break;
      case 4:
        numbers({angles.x(), angles.y(), angles.z()}, 2);
        break;
      case 11:
        numbers({r.quat[0], r.quat[1], r.quat[2], r.quat[3]}, 4);
        break;
      case 16:
        b.push_back(' '), b.push_back(r.pressed ? '1' : '0');
        break;
      default:
        break;
    }
  }
  for (const uint8_t byte : b) {
    if (set_.damage_per_byte > 0 && random_.uniform() < set_.damage_per_byte) {
      const uint64_t how = random_.next() % 3;
      if (how == 0) continue;
      out_.push_back(how == 1 ? uint8_t(random_.next()) : byte);
      if (how == 2) out_.push_back(uint8_t(random_.next()));
    } else {
      out_.push_back(byte);
    }
  }
}

std::vector<uint8_t> Emulator::send(int64_t now_ns) {
  constexpr auto kSampleNs = int64_t(1e9 / kStationsTogetherHz);
  while (continuous_ && !stopped_ && layout_.active_count() > 0 && next_sample_ns_ + set_.output_delay_ns <= now_ns) {
    do next_station_ = next_station_ % kStations + 1;
    while (!layout_.active[size_t(next_station_ - 1)]);
    record(next_station_, next_sample_ns_);
    next_sample_ns_ += kSampleNs;
  }
  if (stopped_) return {};
  std::vector<uint8_t> o;
  o.swap(out_);
  return o;
}

Motion hand_at_work(uint64_t seed) {
  struct Parts {
    Tremor fore, thumb, stylus;
    std::array<std::array<double, 3>, 9> wave;  // amplitude mm, Hz, phase
  };
  RandomStream random(seed);
  auto parts = std::make_shared<Parts>(Parts{
      Tremor(random.next(), 0.12, 8, 12), Tremor(random.next(), 0.12, 8, 12), Tremor(random.next(), 0.12, 8, 12), {}});
  for (auto& w : parts->wave)
    w = {20 + 30 * random.uniform(), 0.15 + 0.35 * random.uniform(), 2 * std::numbers::pi * random.uniform()};
  return [parts](int station, double t) {
    const auto wave = [&](size_t k) {
      return parts->wave[k][0] * elementary::sin(2 * std::numbers::pi * parts->wave[k][1] * t + parts->wave[k][2]);
    };
    StationPose p;
    if (station >= 3) {
      p.pos_mm = Vec3(350 + wave(0), 120 + wave(1), -120 + wave(2)) + parts->stylus.at(t);
      p.orientation = turn_about(0.01 * wave(3), Vec3::UnitX()) * turn_about(0.01 * wave(4), Vec3::UnitY());
      p.pressed = std::fmod(t, 2.0) > 1.2;
      return p;
    }
    const Eigen::Quaterniond hand =
        turn_about(0.012 * wave(3), Vec3::UnitZ()) * turn_about(0.008 * wave(4), Vec3::UnitY());
    const double cycle = std::fmod(t, 2.0);  // open, close in 0.25 s, hold, open in 0.25 s
    const double closed = minimum_jerk((cycle - 0.8) / 0.25) - minimum_jerk((cycle - 1.6) / 0.25);
    const double aperture = 80 - 62 * closed;
    const Vec3 centre(350 + wave(5), -100 + wave(6), -120 + wave(7));
    p.pos_mm = centre + hand * Vec3(0, station == 1 ? aperture / 2 : -aperture / 2, 0) +
               (station == 1 ? parts->fore : parts->thumb).at(t);
    p.orientation = hand;
    return p;
  };
}

}  // namespace limberg::fastrak
