#include "tests/fuzz/entries.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/program/places.h"
#include "app/program/temporary_folder.h"
#include "sim/base/error.h"
#include "tests/bench/fuzz/readers.h"
#include "tests/fuzz/entry_parts.h"

namespace limberg::fuzz {

namespace fs = std::filesystem;

void write_file(const std::string& path, std::string_view content) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << content;
}

std::string shipped(const std::string& name) {
  std::ifstream in(fs::path(source_dir()) / name, std::ios::binary);
  std::ostringstream s;
  s << in.rdbuf();
  if (!in || s.str().empty()) throw InputError(name, 0, "cannot be read; expected a file of the source tree");
  return s.str();
}

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

Entry text_entry(const std::string& name, std::vector<std::string> reads, std::vector<std::string> sound,
                 const TextReader& read) {
  Entry e{name, std::move(reads), std::move(sound), {}};
  e.run = [read](std::string_view bytes, bool& taken) {
    return outcome(kNamed, taken, [&] { return read(std::string(bytes)); });
  };
  return e;
}

Entry path_entry(const std::string& name, const Folder& folder, const std::string& file, std::vector<std::string> reads,
                 std::vector<std::string> sound, const PathReader& read) {
  Entry e{name, std::move(reads), std::move(sound), {}};
  const fs::path place = folder->path() / name;
  fs::create_directories(place);
  e.run = [path = (place / file).string(), place = place.string(), read, folder](std::string_view bytes, bool& taken) {
    write_file(path, bytes);
    return outcome(place, taken, [&] { return read(path); });
  };
  return e;
}

std::vector<Entry> entries() {
  std::vector<Entry> all;
  const auto folder = std::make_shared<TemporaryFolder>();
  for (std::vector<Entry> part : {file_entries(folder), text_entries(folder), stream_entries()})
    std::move(part.begin(), part.end(), std::back_inserter(all));
  return all;
}

std::string corpus_of(const Entry& entry) {
  return (fs::path(source_dir()) / "tests/fuzz/corpus" / entry.name).string();
}

}  // namespace limberg::fuzz
