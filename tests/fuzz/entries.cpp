#include "tests/fuzz/entries.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "devices/fastrak/protocol.h"
#include "devices/message_codec.h"
#include "devices/recording.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"
#include "tests/bench/fuzz/readers.h"

namespace limberg::fuzz {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, std::string_view content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

std::string shipped(const std::string& name) {
  std::ifstream in(fs::path(source_dir()) / name, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  if (!in || s.str().empty()) throw InputError(name, 0, "cannot be read; expected a file of the source tree");
  return s.str();
}

/// `read` throws what the reader throws, and returns what is unsound in what was taken.
std::string outcome(const std::string& file, bool& taken, const std::function<std::string()>& read) {
  taken = false;
  try {
    const std::string fault = read();
    taken = true;
    return fault;
  } catch (const InputError& e) {
    return bench::fault_of_refusal(e.what(), file);
  } catch (const std::exception& e) {
    return std::string("threw what is no InputError: ") + e.what();
  }
}

/// A reader of files: the bytes take the place of the file that is opened, or of the first one of a series.
Entry file_entry(const bench::Reader& reader, size_t variant, const std::shared_ptr<TemporaryFolder>& folder) {
  const bench::SoundFiles& files = reader.sound[variant];
  Entry e;
  e.name = fmt::format("{}_{}", reader.name, variant);
  size_t hit = 0;
  while (!files.open.empty() && files.file[hit].first != files.open) ++hit;
  e.sound.push_back(files.file[hit].second);
  const fs::path place = fs::path(folder->path()) / e.name;
  fs::create_directories(place);
  for (const auto& [name, content] : files.file) write_file(place / name, content);
  e.run = [place, name = files.file[hit].first, series = files.open.empty(), read = reader.read, folder](
              std::string_view bytes, bool& taken) {
    write_file(place / name, bytes);
    return outcome(place.string(), taken, [&] { return read((series ? place : place / name).string()); });
  };
  return e;
}

Entry text_entry(const std::string& name, std::vector<std::string> sound,
                 const std::function<std::string(std::string_view)>& read) {
  Entry e;
  e.name = name, e.sound = std::move(sound);
  e.run = [read](std::string_view bytes, bool& taken) { return outcome("fuzzed", taken, [&] { return read(bytes); }); };
  return e;
}

std::string sound_script(std::string_view text) {
  const Script s = parse_script(text, "fuzzed");
  for (const ScriptLine& l : s.lines) parse_command(to_json_line(l.command), "written", 1);
  return "";
}

std::string sound_recording(std::string_view bytes) {
  const Recording r = read_recording(std::vector<uint8_t>(bytes.begin(), bytes.end()), "fuzzed");
  for (const Sample& s : r.samples)
    if (const auto* stylus = std::get_if<StylusSample>(&s); stylus && !stylus->tip_mm.allFinite())
      return "a sample at no place was taken";
  return "";
}

/// A message as it comes from the network: refused with a reason, or a sample that is encoded and read again.
template <class M, class S>
Entry packet_entry(const std::string& name, const S& sample) {
  Entry e;
  e.name = "packet_" + name;
  MessageBytes bytes;
  const size_t n = encode_message(to_message(sample), bytes);
  e.sound.emplace_back(bytes.begin(), bytes.begin() + ptrdiff_t(n));
  e.run = [](std::string_view packet, bool& taken) -> std::string {
    taken = false;
    M message;
    S got;
    if (decode_message(reinterpret_cast<const uint8_t*>(packet.data()), packet.size(), message)) return "";
    if (to_sample(message, got, true)) return "";
    taken = true;
    MessageBytes again;
    const size_t size = encode_message(to_message(got), again);
    M second;
    S back;
    if (decode_message(again.data(), size, second) || to_sample(second, back, true))
      return "a packet was taken that is refused when it is written again";
    return "";
  };
  return e;
}

/// A stretch of the tracker's line: whatever comes, records lie within reach and turn by unit quaternions.
Entry line_entry(bool binary) {
  using namespace fastrak;
  struct Take final : Parser::Sink {
    void on_record(const Record& r) override {
      ++records;
      double qq = 0;
      for (const double q : r.quat) qq += q * q;
      unsound |= !r.pos_mm.allFinite() || !(r.pos_mm.cwiseAbs().maxCoeff() <= kReachMm) || !(std::abs(qq - 1) < 1e-9) ||
                 r.station < 1 || r.station > kStations;
    }
    void on_reply(std::span<const char> text) override { unsound |= text.size() > kLongest; }
    int records = 0;
    bool unsound = false;
  };
  Layout layout;
  layout.binary = binary;
  Entry e;
  e.name = binary ? "line_binary" : "line_ascii";
  std::string sound;
  for (int station = 1; station <= 2; ++station) {
    Record r;
    r.station = station, r.pos_mm = {120, -35.5, 8}, r.quat = {0.6, 0, 0.8, 0};
    std::array<uint8_t, kLongest> bytes;
    sound.append(reinterpret_cast<const char*>(bytes.data()), encode(r, layout, bytes));
  }
  e.sound.push_back(sound);
  e.run = [layout](std::string_view bytes, bool& taken) -> std::string {
    Parser parser;
    parser.reset(layout);
    Take take;
    for (const char c : bytes) parser.feed(uint8_t(c), 0, take);
    taken = take.records > 0;
    return take.unsound ? "a record out of range was taken" : "";
  };
  return e;
}

}  // namespace

std::vector<Entry> entries() {
  std::vector<Entry> out;
  const auto folder = std::make_shared<TemporaryFolder>();
  for (const bench::Reader& r : bench::readers())
    for (size_t k = 0; k < r.sound.size(); ++k) out.push_back(file_entry(r, k, folder));
  out.push_back(text_entry("script", {shipped("recordings/rhomboid.jsonl"), shipped("recordings/craniofacial.jsonl")},
                           sound_script));
  out.push_back(text_entry("recording", {shipped("recordings/hand-glove.lcm").substr(0, 60'000)}, sound_recording));
  StylusSample stylus;
  stylus.tip_mm = {1, 2, 3};
  out.push_back(packet_entry<limberg_msg::stylus_t>("stylus", stylus));
  out.push_back(packet_entry<limberg_msg::control_t>("control", ControlSample{}));
  out.push_back(packet_entry<limberg_msg::tracker_t>("tracker", TrackerSample{}));
  out.push_back(packet_entry<limberg_msg::raw_t>("raw", RawSample{}));
  out.push_back(line_entry(true));
  out.push_back(line_entry(false));
  return out;
}

}  // namespace limberg::fuzz
