#include "app/head/cache.h"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>

#include "app/program/version.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/skull/simplex/file.h"

namespace limberg {

namespace fs = std::filesystem;

namespace {

/// Where heads are kept; empty: nowhere. A program that differs from its commit keeps none: nobody could tell its heads
/// apart.
fs::path cache_folder() {
  if (std::string(commit()).find("dirty") != std::string::npos || std::string(commit()) == "unknown") return {};
  if (const char* own = std::getenv("LIMBERG_CACHE")) return own;
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg) return fs::path(xdg) / "limberg";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "limberg";
  return {};
}

std::string name_of(const HeadSpec& s) {
  Hash64 h;
  const std::string program = program_name();
  h.bytes(program.data(), program.size());
  for (const double v :
       {s.mandible_scale, s.ramus_left, s.vault_wide, s.vault_long, s.forehead_flat, s.edge_mm, s.face_edge_mm})
    h.add(v);
  return fmt::format("head-{:016x}", h.value());
}

constexpr const char* kPartNames[] = {"cranium", "mandible", "face"};
simplex::Mesh& part(HeadModel& m, int k) { return k == 0 ? m.cranium : k == 1 ? m.mandible : m.face; }

std::optional<HeadModel> read(const fs::path& folder) {
  std::error_code none;
  if (folder.empty() || !fs::is_directory(folder, none)) return {};
  try {
    HeadModel m;
    for (int k = 0; k < 3; ++k)
      part(m, k) = simplex::load_mesh((folder / (std::string(kPartNames[k]) + ".simplex")).string());
    std::ifstream in(folder / "landmarks.txt");
    std::string name, x[3];
    while (in >> name >> x[0] >> x[1] >> x[2]) {
      Vec3 at;
      for (int k = 0; k < 3; ++k)
        if (std::from_chars(x[k].data(), x[k].data() + x[k].size(), at[k]).ec != std::errc()) return {};
      m.landmarks.emplace_back(name, at);
    }
    if (m.landmarks.empty()) return {};
    return m;
  } catch (const InputError&) {
    return {};  // damaged: it is made anew
  }
}

/// Whole or not at all: into a folder of its own first, which then gets the name.
void keep(const fs::path& folder, HeadModel& m) {
  std::error_code ec;
  const fs::path aside = folder.string() + "." + std::to_string(getpid());
  fs::create_directories(aside, ec);
  if (ec) return;
  try {
    for (int k = 0; k < 3; ++k)
      simplex::save_mesh(part(m, k), (aside / (std::string(kPartNames[k]) + ".simplex")).string());
    std::ofstream out(aside / "landmarks.txt");
    for (const auto& [name, at] : m.landmarks) {
      out << name;
      for (int k = 0; k < 3; ++k) {
        char text[40];
        out << ' ' << std::string_view(text, size_t(std::to_chars(text, text + sizeof text, at[k]).ptr - text));
      }
      out << '\n';
    }
    out.close();
    if (out) fs::remove_all(folder, ec), fs::rename(aside, folder, ec);
  } catch (const InputError&) {
  }
  fs::remove_all(aside, ec);
}

}  // namespace

HeadModel cached_head(const HeadSpec& spec, Workers& workers) {
  const fs::path cache = cache_folder(), folder = cache.empty() ? cache : cache / name_of(spec);
  if (std::optional<HeadModel> kept = read(folder)) return std::move(*kept);
  HeadModel m = make_head(spec, workers);
  for (int k = 0; k < 3; ++k) part(m, k) = simplex::parse_mesh(simplex::to_text(part(m, k)), kPartNames[k]);
  if (!folder.empty()) keep(folder, m);
  return m;
}

}  // namespace limberg
