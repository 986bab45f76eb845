#include "app/operating_point/kept_trials.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/whole_file.h"

namespace limberg::bench {
namespace {

constexpr size_t kMostBytes = size_t(16) << 20;

std::string cell_text(const AccuracyTrial& t) { return fmt::format("{:.9g}", t.cell_mm); }
std::string trial_name(const AccuracyTrial& t) {
  return cell_text(t) + "|" + t.element + "|" + t.material + "|" + t.step + "|" + std::to_string(t.iterations);
}

}  // namespace

std::vector<AccuracyTrial> parse_kept_trials(const std::string& text, const std::string& title) {
  std::vector<AccuracyTrial> all;
  std::istringstream in(text);
  std::string line;
  if (!std::getline(in, line) || line != title) return all;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::vector<std::string> w;
    for (std::string word; std::getline(words, word, '\t');) w.push_back(word);
    if (w.size() != 14 || w[13] != ".") continue;
    try {
      AccuracyTrial t;
      t.cell_mm = std::stod(w[0]), t.element = w[1], t.material = w[2], t.step = w[3], t.iterations = std::stoi(w[4]);
      t.own_kind = w[5] == "1", t.nodes = size_t(std::stoul(w[6])), t.frame_ms = std::stod(w[7]),
      t.frame_p95_ms = std::stod(w[8]);
      t.error_mm = std::stod(w[9]), t.error_max_mm = std::stod(w[10]), t.lattice_mm = std::stod(w[11]),
      t.behind_mm = std::stod(w[12]);
      bool sound = t.cell_mm > 0 && t.iterations >= 0;
      for (const double v :
           {t.cell_mm, t.frame_ms, t.frame_p95_ms, t.error_mm, t.error_max_mm, t.lattice_mm, t.behind_mm})
        sound = sound && std::isfinite(v);
      if (sound) all.push_back(std::move(t));
    } catch (const std::exception&) {
      continue;  // as a line that was cut off
    }
  }
  return all;
}

std::string kept_line(const AccuracyTrial& t) {
  return fmt::format("{}\t{}\t{}\t{}\t{}\t{}\t{}\t{:.9g}\t{:.9g}\t{:.9g}\t{:.9g}\t{:.9g}\t{:.9g}\t.\n", cell_text(t),
                     t.element, t.material, t.step, t.iterations, int(t.own_kind), t.nodes, t.frame_ms, t.frame_p95_ms,
                     t.error_mm, t.error_max_mm, t.lattice_mm, t.behind_mm);
}

KeptTrials::KeptTrials(const std::string& file, const std::string& title) : file_(file) {
  if (file_.empty()) return;
  std::error_code none;
  const std::string text = std::filesystem::exists(file_, none)
                               ? read_whole_file(file_, kMostBytes, "a file for finished trials")
                               : std::string();
  for (AccuracyTrial& t : parse_kept_trials(text, title)) trials_[trial_name(t)] = t;
  const bool same = text.starts_with(title + "\n");
  std::ofstream out(file_, same ? std::ios::app : std::ios::trunc);
  if (!out) throw InputError(file_, 0, "cannot be written; a file for finished trials was expected");
  out << (same ? "\n" : title + "\n");  // (a blank line ends one that was cut off)
}

const AccuracyTrial* KeptTrials::find(const AccuracyTrial& t) const {
  const auto it = trials_.find(trial_name(t));
  return it == trials_.end() ? nullptr : &it->second;
}

void KeptTrials::add(const AccuracyTrial& t) const {
  if (file_.empty()) return;
  std::ofstream(file_, std::ios::app) << kept_line(t);
}

}  // namespace limberg::bench
