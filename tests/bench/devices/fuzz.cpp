#include "tests/bench/devices/fuzz.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "app/operating_point/cpu_clock.h"
#include "devices/fastrak/link.h"
#include "devices/message_codec.h"
#include "devices/motion.h"
#include "devices/recording.h"
#include "sim/base/error.h"

namespace limberg::bench {

namespace {

using namespace fastrak;
using Family = DevicesFuzzReport::Family;
using Bytes = std::vector<uint8_t>;

struct Dice : RandomStream {
  using RandomStream::RandomStream;
  size_t below(size_t n) { return size_t(next() % n); }
};

struct Fuzzer {
  DevicesFuzzReport& report;
  Dice dice;

  void violated(Family& f, const std::string& what) {
    ++f.violations;
    if (report.first_violation.empty()) report.first_violation = what;
  }

  Record any_record(const Layout& layout) {
    Record r;
    do r.station = 1 + int(dice.below(kStations));
    while (!layout.active[size_t(r.station - 1)]);
    for (int i = 0; i < 3; ++i) r.pos_mm[i] = 1000 * (dice.uniform() - 0.5);
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(dice.normal(), dice.normal(), dice.normal(), dice.normal() + 1e-9).normalized();
    r.quat = {q.w(), q.x(), q.y(), q.z()};
    r.pressed = dice.below(2) && layout.has_switch[size_t(r.station - 1)];
    return r;
  }

  /// One to eight changes anywhere.
  void damage(Bytes& b, size_t changes) {
    for (size_t k = 0; k < changes && !b.empty(); ++k) {
      const size_t at = dice.below(b.size());
      const auto p = b.begin() + long(at);
      switch (dice.below(6)) {
        case 0:
          b[at] = uint8_t(dice.next());
          break;
        case 1:
          b[at] ^= uint8_t(1u << dice.below(8));
          break;
        case 2:
          b.erase(p);
          break;
        case 3:
          b.insert(p, uint8_t(dice.next()));
          break;
        case 4:
          b.erase(p, b.begin() + long(std::min(b.size(), at + 1 + dice.below(40))));
          break;
        default: {
          Bytes noise(1 + dice.below(20));
          for (uint8_t& x : noise) x = uint8_t(dice.next());
          b.insert(p, noise.begin(), noise.end());
        }
      }
    }
  }
};

struct Take final : Parser::Sink {
  void on_record(const Record& r) override { got.push_back(r); }
  void on_reply(std::span<const char> text) override { replies += text.size() + 2; }
  std::vector<Record> got;
  size_t replies = 0;
};

bool same(const Record& a, const Record& b) {
  return a.station == b.station && a.pressed == b.pressed && a.pos_mm == b.pos_mm && a.quat == b.quat;
}
bool far(const Record& a, const Record& b) {
  double dot = 0;
  for (size_t k = 0; k < 4; ++k) dot += a.quat[k] * b.quat[k];
  return (a.pos_mm - b.pos_mm).norm() > 3 || 2 * std::acos(std::min(1.0, std::abs(dot))) * 180 / std::numbers::pi > 3;
}

void check(Fuzzer& f, Family& family, const Record& r, const Layout& layout) {
  double qq = 0;
  for (const double q : r.quat) qq += q * q;
  if (!r.pos_mm.allFinite() || r.pos_mm.cwiseAbs().maxCoeff() > kReachMm || !(std::abs(qq - 1) < 1e-9) ||
      r.station < 1 || r.station > kStations || !layout.active[size_t(r.station - 1)])
    f.violated(family, "a record out of range was taken");
}

/// Three records; the middle one is hit. `replace`: by exactly one other byte.
void line_case(Fuzzer& f, Family& family, bool replace) {
  Layout layout;
  layout.binary = f.dice.below(2);
  for (size_t i = 0; i < layout.active.size(); ++i)
    layout.active[i] = i == 0 || f.dice.below(2), layout.has_switch[i] = layout.active[i] && f.dice.below(2);
  if (replace) layout = Layout{};
  std::array<Record, 3> sent;
  std::array<Bytes, 3> bytes;
  for (size_t k = 0; k < 3; ++k) {
    std::array<uint8_t, kLongest> b;
    const size_t n = encode(sent[k] = f.any_record(layout), layout, b);
    bytes[k].assign(b.begin(), b.begin() + long(n));
  }
  if (replace) {
    uint8_t& b = bytes[1][f.dice.below(bytes[1].size())];
    b = uint8_t(b + 1 + f.dice.below(255));
  } else {
    f.damage(bytes[1], 1 + f.dice.below(3));
  }
  // The records as a whole line would give them: the numbers of the format, not those before it.
  Take whole, take;
  Parser reference, parser;
  reference.reset(layout), parser.reset(layout);
  size_t total = 0;
  for (size_t k = 0; k < 3; ++k) {
    std::array<uint8_t, kLongest> b;
    const size_t n = encode(sent[k], layout, b);
    for (size_t i = 0; i < n; ++i) reference.feed(b[i], 0, whole);
    for (const uint8_t x : bytes[k]) parser.feed(x, 0, take), ++total;
  }
  ++family.cases;
  if (whole.got.size() != 3) return f.violated(family, "a whole record was not taken");
  size_t consumed = take.replies;
  for (const Record& r : take.got) {
    check(f, family, r, layout);
    consumed += layout.record_bytes(r.station);
    bool known = false, near = false;
    for (const Record& w : whole.got) known |= same(r, w), near |= !far(r, w);
    ++family.taken;
    family.wrong += !known;
    family.far += !near;
  }
  const Parser::Counts& c = parser.counts();
  if (size_t(c.bytes) != total || consumed + size_t(c.skipped_bytes) > total ||
      total - consumed - size_t(c.skipped_bytes) >= kLongest)
    f.violated(family, "bytes were lost count of");
}

/// Nothing but noise of the length of a record.
void noise_case(Fuzzer& f, Family& family, Parser& parser, const Layout& layout) {
  Take take;
  for (size_t i = 0; i < layout.record_bytes(1); ++i) parser.feed(uint8_t(f.dice.next()), 0, take);
  ++family.cases;
  for (const Record& r : take.got) check(f, family, r, layout), ++family.wrong, ++family.far;
}

struct Readings final : fastrak::Link::Receiver {
  void on_reading(const TrackerSample& s) override {
    ++n;
    bad |= s.seq < 0 || s.station < 1 || s.station > kStations || s.true_ns > s.t_ns || !s.pos_mm.allFinite();
  }
  int64_t n = 0;
  bool bad = false;
};

/// The conversation with bytes that make sense here and there, at odd times.
void talk_case(Fuzzer& f, Family& family, fastrak::Link& link, int64_t& now_ns) {
  static constexpr std::string_view pieces[] = {"21S                                                  \r\n",
                                                "21l1100\r\n",
                                                "2",
                                                "\r\n",
                                                "01 ",
                                                "21l",
                                                "21l0000\r\n"};
  Readings readings;
  Bytes b;
  switch (f.dice.below(4)) {
    case 0: {
      const std::string_view p = pieces[f.dice.below(std::size(pieces))];
      b.assign(p.begin(), p.end());
      break;
    }
    case 1: {
      std::array<uint8_t, kLongest> record;
      const size_t n = encode(f.any_record({}), {}, record);
      b.assign(record.begin(), record.begin() + long(n));
      break;
    }
    case 2:
      b.resize(f.dice.below(200));
      for (uint8_t& x : b) x = uint8_t(f.dice.next());
      break;
    default:
      break;
  }
  if (f.dice.below(4) == 0) f.damage(b, 1);
  now_ns += int64_t(f.dice.below(f.dice.below(10) ? 30'000'000 : 3'000'000'000));
  if (f.dice.below(500) == 0) f.dice.below(2) ? link.closed() : link.opened(now_ns);
  link.receive(b.data(), b.size(), now_ns, readings);
  link.tick(now_ns);
  ++family.cases;
  if (readings.bad) f.violated(family, "a reading out of range");
  if (link.take_output().size() > 4096) f.violated(family, "it talks without end");
  if (link.phase() == fastrak::Link::Phase::closed && f.dice.below(3) == 0) link.opened(now_ns);
}

template <class M, class S>
void packet_case(Fuzzer& f, Family& family, const S& sent) {
  MessageBytes bytes;
  const size_t n = encode_message(to_message(sent), bytes);
  Bytes b(bytes.begin(), bytes.begin() + long(n));
  const Bytes before = b;
  f.damage(b, 1 + f.dice.below(8));
  ++family.cases;
  M m;
  S s;
  bool has_checksum = false;
  if (decode_message(b.data(), b.size(), m, &has_checksum) || to_sample(m, s) || !has_checksum)
    return;  // of a stream that has them
  ++family.taken;
  family.wrong += b != before;
}

void some_packet(Fuzzer& f, Family& family) {
  const int64_t t = int64_t(f.dice.below(1'000'000'000));
  switch (f.dice.below(4)) {
    case 0: {
      StylusSample s;
      s.seq = t, s.t_ns = t, s.tip_mm = Vec3(f.dice.uniform(), 2, 3);
      return packet_case<limberg_msg::stylus_t>(f, family, s);
    }
    case 1: {
      ControlSample s;
      s.seq = t, s.t_ns = t, s.tool = Tool::hook;
      return packet_case<limberg_msg::control_t>(f, family, s);
    }
    case 2: {
      TrackerSample s;
      s.seq = t, s.t_ns = t, s.true_ns = t - 4'000'000, s.pos_mm = Vec3(f.dice.uniform(), 2, 3);
      return packet_case<limberg_msg::tracker_t>(f, family, s);
    }
    default: {
      RawSample s;
      s.seq = t, s.t_ns = t, s.n = 64;
      for (uint8_t& x : s.bytes) x = uint8_t(f.dice.next());
      return packet_case<limberg_msg::raw_t>(f, family, s);
    }
  }
}

/// A small recording, event by event as bytes of a log.
Bytes log_of(Fuzzer& f, int events, std::set<int64_t>& sent) {
  Bytes out;
  const auto put = [&](uint64_t v, int n) {
    for (int i = n - 1; i >= 0; --i) out.push_back(uint8_t(v >> (8 * i)));
  };
  for (int i = 0; i < events; ++i) {
    StylusSample s;
    s.seq = i, s.t_ns = int64_t(i) * 8'333'333 + int64_t(f.dice.below(1000)), s.tip_mm = Vec3(i, 0, 0);
    sent.insert(s.t_ns * 1000 + i);
    MessageBytes bytes;
    const size_t n = encode_message(to_message(s), bytes);
    put(LogReader::kSync, 4), put(uint64_t(i), 8), put(uint64_t(s.t_ns / 1000), 8), put(kStylusChannel.size(), 4),
        put(n, 4);
    out.insert(out.end(), kStylusChannel.begin(), kStylusChannel.end());
    out.insert(out.end(), bytes.begin(), bytes.begin() + long(n));
  }
  return out;
}

void log_case(Fuzzer& f, Family& family) {
  constexpr int kEvents = 24;
  std::set<int64_t> sent;
  Bytes b = log_of(f, kEvents, sent);
  const size_t hits = 1 + f.dice.below(6);
  f.damage(b, hits);
  if (f.dice.below(4) == 0 && b.size() > 2) {
    const size_t from = f.dice.below(b.size()), n = f.dice.below(b.size() - from);
    const Bytes part(b.begin() + long(from), b.begin() + long(from + n));
    if (f.dice.below(2))
      b.insert(b.begin() + long(f.dice.below(b.size())), part.begin(), part.end());
    else
      b.erase(b.begin() + long(from), b.begin() + long(from + n));
  }
  family.cases += int64_t(hits);
  try {
    const Recording r = read_recording(std::move(b), "fuzz");
    int64_t last = -1, last_seq = -1, first = -1;
    for (const Sample& sample : r.samples) {
      const auto* s = std::get_if<StylusSample>(&sample);
      if (!s || s->t_ns < last || s->seq <= last_seq || !s->tip_mm.allFinite())
        return f.violated(family, "a log gave samples out of order or not finite");
      last = s->t_ns, last_seq = s->seq;
      ++family.taken;
      // A plain stream counts from its first sample's millisecond on.
      if (first < 0) {
        const auto it = std::find_if(sent.begin(), sent.end(), [&](int64_t k) { return k % 1000 == s->seq; });
        first = it == sent.end() ? 0 : *it / 1000 - s->t_ns;
      }
      family.wrong += !sent.contains((s->t_ns + first) * 1000 + s->seq);
    }
    if (r.samples.size() > size_t(kEvents)) f.violated(family, "a log gave more samples than it had");
  } catch (const InputError&) {
  }
}

template <class F>
void timed(Family& f, F&& body) {
  const double before = cpu_ms();
  body();
  f.cpu_ms += cpu_ms() - before;
}

}  // namespace

DevicesFuzzReport devices_fuzz(const DevicesFuzzSettings& set) {
  DevicesFuzzReport report;
  report.seed = set.seed;
  Fuzzer f{report, Dice(set.seed * 0x100000001b3ull + 5)};
  Layout layout;
  Parser noise_parser;
  noise_parser.reset(layout);
  fastrak::Link link{LinkSettings{}};
  int64_t now_ns = 0;
  link.opened(now_ns);
  // What passes depends on the record: the mean over some, and five times its own uncertainty on top.
  constexpr int kExamples = 32;
  const auto expected = [&](double far) {
    double sum = 0, sum2 = 0;
    for (int i = 0; i < kExamples; ++i) {
      const double share = accepted_share(f.any_record(layout), layout, far, far);
      sum += share, sum2 += share * share;
    }
    const double mean = sum / kExamples;
    return mean + 5 * std::sqrt(std::max(0.0, sum2 / kExamples - mean * mean) / kExamples);
  };
  report.replaced.expected_wrong = expected(0);
  report.expected_far = expected(3);
  const int64_t share = std::max<int64_t>(1, set.cases / 6);
  // In slices, so that a long run says how far it is.
  constexpr int kSlices = 12;
  for (int slice = 1; slice <= kSlices; ++slice) {
    const int64_t upto = share * slice / kSlices;
    timed(report.line, [&] {
      while (report.line.cases < upto) line_case(f, report.line, false);
    });
    timed(report.replaced, [&] {
      while (report.replaced.cases < upto) line_case(f, report.replaced, true);
    });
    timed(report.noise, [&] {
      while (report.noise.cases < upto / 2) noise_case(f, report.noise, noise_parser, layout);
    });
    timed(report.talk, [&] {
      while (report.talk.cases < upto / 2) talk_case(f, report.talk, link, now_ns);
    });
    timed(report.packet, [&] {
      while (report.packet.cases < 2 * upto) some_packet(f, report.packet);
    });
    timed(report.log, [&] {
      while (report.log.cases < upto) log_case(f, report.log);
    });
    if (set.progress)
      set.progress(std::to_string(report.cases()) + " cases, " + std::to_string(report.violations()) + " violations");
  }
  return report;
}

Result DevicesFuzzReport::result() const {
  Result out;
  const auto row = [&](const char* name, const Family& f, const char* what) {
    Row r;
    r.name = name;
    r.method = what;
    r.settings = std::to_string(f.cases) + " cases, " + std::to_string(f.taken) + " taken, " + std::to_string(f.wrong) +
                 " wrong, " + std::to_string(f.far) + " far, seed " + std::to_string(seed);
    r.time_ms = f.cpu_ms;
    r.error = f.cases ? double(f.wrong) / double(f.cases) : 0;
    r.error_unit = "wrong/case";
    r.reference = "what was sent";
    r.pass = f.violations == 0;
    out.rows.push_back(r);
  };
  row("line", line, "one of three records hit, any way");
  row("line, one byte", replaced, "one byte of a record replaced");
  row("line, noise", noise, "nothing but noise");
  row("conversation", talk, "bytes at odd times");
  row("packet", packet, "LCM message hit");
  row("log", log, "recording hit");
  const auto bar = [&](const char* name, double value, double limit, const char* source) {
    out.bars.push_back({name, value, false, limit, false, value <= limit, source});
  };
  bar("violations", double(violations()), 0, "no damage may break an invariant");
  // Five standard deviations of a count: by chance once in three million runs.
  const auto limit = [](double share, int64_t cases) {
    return share + 5 * std::sqrt(share / double(std::max<int64_t>(1, cases)));
  };
  bar("line, one byte: wrong pose taken, share", double(replaced.wrong) / double(std::max<int64_t>(1, replaced.cases)),
      limit(replaced.expected_wrong, replaced.cases),
      "fastrak::accepted_share, by trying all bytes and values; no checksum on the line");
  bar("line, one byte: more than 3 mm or 3 deg off, share",
      double(replaced.far) / double(std::max<int64_t>(1, replaced.cases)), limit(expected_far, replaced.cases),
      "the same; left to the jump gate");
  bar("line: noise taken for a record", double(noise.wrong), 0, "2^-40 a byte before its quaternion is looked at");
  bar("packet: wrong taken", double(packet.wrong), 0, "CRC-32: 2^-32 a case");
  bar("log: wrong taken", double(log.wrong), 0, "CRC-32: 2^-32 a case");
  if (!first_violation.empty()) out.notes.push_back("first violation: " + first_violation);
  return out;
}

}  // namespace limberg::bench
