// Which series of a disc shows a head best (dicom.h).
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "sim/imaging/io/dicom.h"

namespace limberg::imaging {
namespace {

constexpr int kFewestSlices = 12;
constexpr double kLeastHeight_mm = 80, kHead_mm = 260, kAsMuch = 0.9;

std::string upper(std::string s) {
  for (char& c : s) c = char(std::toupper(static_cast<unsigned char>(c)));
  return s;
}
bool has_word(const std::string& text, std::initializer_list<const char*> words) {
  const std::string t = upper(text);
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return t.find(w) != std::string::npos; });
}

bool of_other_part(const SeriesAbout& s) {
  return has_word(s.body_part, {"CHEST", "THORAX", "ABDOMEN", "PELVIS", "HIP", "LEG", "KNEE", "FOOT", "ANKLE", "ARM",
                                "HAND", "WRIST", "ELBOW", "SHOULDER", "LSPINE", "TSPINE", "HEART", "EXTREMITY"}) &&
         !has_word(s.body_part, {"HEAD", "SKULL", "BRAIN", "FACE", "NECK"});
}

/// Why a series will not do, whatever the others are; empty: it will.
std::string unfit(const SeriesAbout& s) {
  if (s.modality != "CT" && s.modality != "MR") return "is " + s.modality.substr(0, 16) + ", no CT or MR";
  if (has_word(s.image_type, {"LOCALIZER"}) || has_word(s.description, {"SCOUT", "LOCALIZER", "TOPOGRAM", "SURVIEW"}))
    return "is a localizer";
  if (has_word(s.image_type, {"SECONDARY"})) return "is a secondary capture or reformatted (Image Type SECONDARY)";
  if (has_word(s.image_type, {"DERIVED"})) return "is derived from another (Image Type DERIVED)";
  if (s.slices < kFewestSlices) return fmt::format("has {} slices; at least {} were expected", s.slices, kFewestSlices);
  if (!s.refused.empty()) return "cannot be read: " + s.refused;
  if (s.height_mm < kLeastHeight_mm)
    return fmt::format("covers {:.0f} mm of the patient's length; at least {:.0f} were expected", s.height_mm,
                       kLeastHeight_mm);
  return "";
}

std::string named(const SeriesAbout& s) {
  return fmt::format("series {} \"{}\"", s.number, s.description.substr(0, 60));
}

}  // namespace

SeriesChoice choose_series(const std::vector<SeriesAbout>& list) {
  SeriesChoice out;
  std::vector<std::string> why_not(list.size());
  const auto left = [&](auto&& wanted) {
    for (size_t i = 0; i < list.size(); ++i)
      if (why_not[i].empty() && wanted(list[i])) return true;
    return false;
  };
  for (size_t i = 0; i < list.size(); ++i) why_not[i] = unfit(list[i]);
  const auto keep_if_any = [&](const char* reason, auto&& wanted) {
    if (!left(wanted)) return;
    for (size_t i = 0; i < list.size(); ++i)
      if (why_not[i].empty() && !wanted(list[i])) why_not[i] = reason;
  };
  keep_if_any("is MR, and there is CT", [](const SeriesAbout& s) { return s.modality == "CT"; });
  keep_if_any("is of another part of the body", [](const SeriesAbout& s) { return !of_other_part(s); });
  double most_mm = 0;
  int usable = 0;
  const auto height = [](const SeriesAbout& s) { return std::min(s.height_mm, kHead_mm); };
  for (size_t i = 0; i < list.size(); ++i)
    if (why_not[i].empty()) most_mm = std::max(most_mm, height(list[i])), ++usable;
  for (size_t i = 0; i < list.size(); ++i) {
    if (!why_not[i].empty() || height(list[i]) < kAsMuch * most_mm) continue;
    if (out.index < 0 || list[i].gap_mm < list[size_t(out.index)].gap_mm - 1e-6) out.index = int(i);
  }
  std::set<std::string> patients;
  for (const SeriesAbout& s : list) patients.insert(s.patient);
  for (size_t i = 0; i < list.size(); ++i)
    if (!why_not[i].empty()) out.rejected.push_back(named(list[i]) + " " + why_not[i]);
  if (out.index >= 0) {
    const SeriesAbout& s = list[size_t(out.index)];
    out.why = fmt::format("{} is taken: {}, {:.0f} mm of the patient's length, slices every {:.3g} mm{}", named(s),
                          s.modality, s.height_mm, s.gap_mm, s.kernel.empty() ? "" : ", kernel " + s.kernel);
    out.why += usable > 1 ? fmt::format("; of {} that will do it covers most in the finest slices", usable)
                          : std::string("; it is the only one that will do");
    out.why[0] = 'S';
  } else {
    out.why = list.empty() ? "There is no series" : "No series shows a head";
    for (size_t i = 0; i < out.rejected.size() && i < 8; ++i) out.why += (i ? "; " : ": ") + out.rejected[i];
  }
  if (patients.size() > 1) {
    out.why += fmt::format(". Series of {} patients lie here (", patients.size());
    int shown = 0;
    for (const std::string& p : patients)
      if (shown++ < 6) out.why += (shown > 1 ? ", " : "") + (p.empty() ? "no ID" : p.substr(0, 32));
    out.why += out.index >= 0 ? "); this one is of " + list[size_t(out.index)].patient.substr(0, 32) : ")";
  }
  out.why += ".";
  return out;
}

}  // namespace limberg::imaging
