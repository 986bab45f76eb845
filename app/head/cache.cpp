#include "app/head/cache.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>
#include <string_view>

#include "app/program/version.h"
#include "sim/base/error.h"
#include "sim/base/hash.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/anatomical/anatomical_head.h"
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
  if (s.anatomical) h.add(std::string("anatomical"));
  return fmt::format("head-{:016x}", h.value());
}

constexpr const char* kPartNames[] = {"cranium", "mandible", "face"};
simplex::Mesh& part(HeadModel& m, int k) { return k == 0 ? m.cranium : k == 1 ? m.mandible : m.face; }

std::string file_of(const fs::path& folder, int k) {
  return (folder / (std::string(kPartNames[k]) + ".simplex")).string();
}
std::string landmarks_of(const fs::path& folder) { return (folder / "landmarks.txt").string(); }

/// Ours, and nobody else can put anything there. A link is none.
bool is_private(const fs::path& folder) {
  struct stat st {};
  return lstat(folder.c_str(), &st) == 0 && S_ISDIR(st.st_mode) && st.st_uid == geteuid() &&
         (st.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

/// Its first line says what all the rest and the meshes hash to: what was cut off or changed is not believed.
constexpr std::string_view kFirstWord = "landmarks ";
constexpr size_t kFirstLine = kFirstWord.size() + 17;

std::string first_line(std::span<const std::string> meshes, std::string_view landmarks) {
  Hash64 h;
  for (const std::string& mesh : meshes) h.add(mesh);
  h.add(std::string(landmarks));
  return fmt::format("{}{:016x}\n", kFirstWord, h.value());
}

std::optional<HeadModel> read(const fs::path& folder) {
  if (folder.empty() || !is_private(folder.parent_path()) || !is_private(folder)) return {};
  try {
    HeadModel m;
    std::array<std::string, 3> mesh;
    for (int k = 0; k < 3; ++k) mesh[size_t(k)] = read_whole_file(file_of(folder, k), simplex::FileLimits::file_bytes);
    const std::string text = read_whole_file(landmarks_of(folder), size_t(1) << 20);
    if (text.size() <= kFirstLine) return {};
    const std::string_view rest = std::string_view(text).substr(kFirstLine);
    if (!text.starts_with(first_line(mesh, rest))) return {};
    for (int k = 0; k < 3; ++k) part(m, k) = simplex::parse_mesh(mesh[size_t(k)], kPartNames[k]);
    auto landmarks = parse_kept_landmarks(rest);
    if (!landmarks) return {};
    m.landmarks = std::move(*landmarks);
    return m;
  } catch (const InputError&) {
    return {};  // damaged: it is made anew
  }
}

/// Whole or not at all: into a folder of its own first, which then gets the name.
void keep(const fs::path& folder, HeadModel& m) {
  std::error_code ec;
  const fs::path cache = folder.parent_path();
  if (fs::create_directories(cache, ec)) fs::permissions(cache, fs::perms::owner_all, ec);
  if (!is_private(cache)) return;
  std::string aside = (cache / "head-XXXXXX").string();
  if (!mkdtemp(aside.data())) return;  // for its owner only
  try {
    std::array<std::string, 3> mesh;
    for (int k = 0; k < 3; ++k) write_whole_file(file_of(aside, k), mesh[size_t(k)] = simplex::to_text(part(m, k)));
    std::string text;
    for (const auto& [name, at] : m.landmarks) {
      text += name;
      for (int k = 0; k < 3; ++k) {
        char number[40];
        text += ' ';
        text.append(number, std::to_chars(number, number + sizeof number, at[k]).ptr);
      }
      text += '\n';
    }
    write_whole_file(landmarks_of(aside), first_line(mesh, text) + text);
    fs::remove_all(folder, ec), fs::rename(aside, folder, ec);
  } catch (const InputError&) {
  }
  fs::remove_all(aside, ec);
}

}  // namespace

std::optional<std::vector<std::pair<std::string, Vec3>>> parse_kept_landmarks(std::string_view text) {
  std::vector<std::pair<std::string, Vec3>> all;
  std::istringstream in{std::string(text)};
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name, x[3], rest;
    if (!(words >> name >> x[0] >> x[1] >> x[2]) || words >> rest) return {};
    Vec3 at;
    for (int k = 0; k < 3; ++k) {
      const char* end = x[k].data() + x[k].size();
      const auto r = std::from_chars(x[k].data(), end, at[k]);
      if (r.ec != std::errc() || r.ptr != end || !(std::abs(at[k]) <= simplex::FileLimits::extent_mm)) return {};
    }
    all.emplace_back(name, at);
  }
  return all;
}

HeadModel cached_head(const HeadSpec& spec, Workers& workers) {
  return cached_head(spec, workers, cache_folder().string());
}

HeadModel cached_head(const HeadSpec& spec, Workers& workers, const std::string& cache_folder) {
  const fs::path cache = cache_folder, folder = cache.empty() ? cache : cache / name_of(spec);
  if (std::optional<HeadModel> kept = read(folder)) return std::move(*kept);
  HeadModel m = spec.anatomical ? make_anatomical_head(spec, workers) : make_head(spec, workers);
  for (int k = 0; k < 3; ++k) part(m, k) = simplex::parse_mesh(simplex::to_text(part(m, k)), kPartNames[k]);
  if (!folder.empty()) keep(folder, m);
  return m;
}

}  // namespace limberg
