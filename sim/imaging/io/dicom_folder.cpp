#include "sim/imaging/io/dicom_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"
#include "sim/imaging/io/dicom.h"

namespace limberg::imaging {
namespace {

namespace fs = std::filesystem;

struct Walk {
  std::string root;
  std::vector<std::string> files;
  std::set<std::string> walked;  // folders by their canonical names: a link back to one ends there
  int entries = 0;
};

void walk_folder(const fs::path& folder, int depth, bool with_subfolders, Walk& w, DicomFolder& out) {
  std::error_code ec;
  const fs::path canonical = fs::canonical(folder, ec);
  if (!ec && !w.walked.insert(canonical.string()).second) return;
  std::vector<fs::path> entries;
  if (!ec)
    for (fs::directory_iterator i(folder, ec), end; !ec && i != end; i.increment(ec)) {
      if (++w.entries > DicomFolderLimits::entries)
        throw InputError(w.root, 0,
                         "holds more than " + std::to_string(DicomFolderLimits::entries) +
                             " files and folders; expected the folder of one disc or one patient");
      entries.push_back(i->path());
    }
  if (ec && depth == 0) throw InputError(folder.string(), 0, "the folder cannot be read (" + ec.message() + ")");
  if (ec) out.unread.push_back(folder.string() + ": the folder cannot be read (" + ec.message() + ")");
  std::sort(entries.begin(), entries.end());
  for (const fs::path& e : entries) {
    if (fs::is_regular_file(e, ec)) {
      w.files.push_back(e.string());
    } else if (with_subfolders && fs::is_directory(e, ec)) {
      if (depth < DicomFolderLimits::depth)
        walk_folder(e, depth + 1, with_subfolders, w, out);
      else
        ++out.too_deep;
    }
  }
}

/// The same slice again, in another folder: discs keep copies. (In one folder two slices at one place are two series
/// mixed, and are refused.)
bool is_copy(const DicomSeries& s, const DicomFile& d) {
  return !d.instance.empty() && std::any_of(s.slice.begin(), s.slice.end(), [&](const DicomFile& x) {
    return x.instance == d.instance && x.position_mm == d.position_mm &&
           fs::path(x.file).parent_path() != fs::path(d.file).parent_path();
  });
}

/// Volumes of one series are told apart by what their stacks are called.
void name_stacks(std::vector<DicomSeries>& all) {
  for (DicomSeries& s : all) {
    const auto is_one_of_several = [&](const DicomSeries& x) {
      return &x != &s && x.uid == s.uid && x.patient == s.patient;
    };
    if (std::any_of(all.begin(), all.end(), is_one_of_several))
      for (DicomFile& d : s.slice) d.description += ", stack " + d.stack;
  }
}

}  // namespace

bool is_dicomdir(const std::string& path) {
  std::string name = fs::path(path).filename().string();
  for (char& c : name) c = char(std::toupper(static_cast<unsigned char>(c)));
  return name == "DICOMDIR";
}

DicomFolder read_dicom_folder(const std::string& folder, bool with_subfolders) {
  DicomFolder out;
  Walk w;
  w.root = folder;
  walk_folder(folder, 0, with_subfolders, w, out);
  std::sort(w.files.begin(), w.files.end());
  std::set<std::string> instances;  // and their frames, that were read
  for (const std::string& f : w.files) {
    if (is_dicomdir(f)) continue;
    try {
      if (!looks_like_dicom(read_beginning(f, 132))) {
        ++out.other_files;
        continue;
      }
      for (DicomFile& d : read_dicom_header(f)) {
        if (!d.has_pixels) {  // structured reports, presentation states
          ++out.without_pixels;
          break;
        }
        auto s = std::find_if(out.series.begin(), out.series.end(), [&](const DicomSeries& x) {
          return x.uid == d.series && x.patient == d.patient && x.slice.front().stack == d.stack;
        });
        if (s == out.series.end()) s = out.series.insert(s, {d.patient, d.series, {}});
        const std::string instance = fmt::format("{} {} {}", d.series, d.instance, d.frame);
        if (!instances.insert(instance).second && is_copy(*s, d))
          ++out.copies;
        else
          s->slice.push_back(std::move(d));
      }
    } catch (const InputError& e) {
      out.unread.push_back(e.what());  // one bad file hides no other series
    }
  }
  name_stacks(out.series);
  if (out.series.empty())
    throw InputError(folder, 0,
                     "holds no DICOM slices; expected files with DICM behind 128 bytes and with pixels" +
                         (out.unread.empty() ? std::string()
                                             : "; " + std::to_string(out.unread.size()) +
                                                   " cannot be read, the first of them: " + out.unread.front()));
  return out;
}

std::vector<std::string> DicomFolder::notes() const {
  std::vector<std::string> out;
  const auto count = [](int n, const char* one, const char* several) {
    return std::to_string(n) + " " + (n == 1 ? one : several);
  };
  if (other_files > 0) out.push_back(count(other_files, "file is", "files are") + " no DICOM: passed over");
  if (without_pixels > 0)
    out.push_back(count(without_pixels, "DICOM file has", "DICOM files have") + " no pixels: passed over");
  if (copies > 0) out.push_back(count(copies, "slice is", "slices are") + " in two folders: read once");
  if (too_deep > 0)
    out.push_back(count(too_deep, "folder lies", "folders lie") + " more than " +
                  std::to_string(DicomFolderLimits::depth) + " deep: passed over");
  constexpr size_t kNamed = 5;
  for (size_t i = 0; i < unread.size() && i < kNamed; ++i) out.push_back("passed over: " + unread[i].substr(0, 400));
  if (unread.size() > kNamed)
    out.push_back(std::to_string(unread.size() - kNamed) + " more files that cannot be read are passed over");
  return out;
}

}  // namespace limberg::imaging
