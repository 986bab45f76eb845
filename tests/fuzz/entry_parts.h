#pragma once
// What entries.cpp puts together, and what its parts share.
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/entries.h"

namespace limberg {
class TemporaryFolder;
}

namespace limberg::fuzz {

using Folder = std::shared_ptr<TemporaryFolder>;

std::vector<Entry> file_entries(const Folder& folder);  // images, surfaces, meshes, scenes
std::vector<Entry> text_entries(const Folder& folder);  // TOML, JSON, scripts, tables
std::vector<Entry> stream_entries();                    // recordings, logs, packets, lines of devices

/// A file of the source tree.
std::string shipped(const std::string& name);
void write_file(const std::string& path, std::string_view content);

/// `read` throws what the reader throws, and returns what is unsound in what was taken. `file`: what a refusal names.
std::string outcome(const std::string& file, bool& taken, const std::function<std::string()>& read);

inline constexpr const char* kNamed = "fuzzed";  // the file, to a reader of text
using TextReader = std::function<std::string(const std::string& text)>;
Entry text_entry(const std::string& name, std::vector<std::string> reads, std::vector<std::string> sound,
                 const TextReader& read);
/// The same for a reader that opens its file itself.
using PathReader = std::function<std::string(const std::string& path)>;
Entry path_entry(const std::string& name, const Folder& folder, const std::string& file, std::vector<std::string> reads,
                 std::vector<std::string> sound, const PathReader& read);

}  // namespace limberg::fuzz
