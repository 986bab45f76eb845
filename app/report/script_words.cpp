#include "app/report/script_words.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/report/html.h"

namespace limberg {

namespace {

using Json = nlohmann::json;

double word_number(const Json& j, const char* name) {
  const auto it = j.find(name);
  return it != j.end() && it->is_number() ? it->get<double>() : NAN;
}

// Points of a list [[x, y], ...]; anything else ends it.
std::vector<std::pair<double, double>> points(const Json& j, const char* name) {
  std::vector<std::pair<double, double>> p;
  const auto it = j.find(name);
  if (it == j.end() || !it->is_array()) return p;
  for (const Json& q : *it) {
    if (!q.is_array() || q.size() < 2 || !q[0].is_number() || !q[1].is_number()) break;
    p.emplace_back(q[0].get<double>(), q[1].get<double>());
  }
  return p;
}

double length_mm(const std::vector<std::pair<double, double>>& p) {
  double l = 0;
  for (size_t i = 1; i < p.size(); ++i) l += std::hypot(p[i].first - p[i - 1].first, p[i].second - p[i - 1].second);
  return l;
}

double area_mm2(const std::vector<std::pair<double, double>>& p) {
  double a = 0;
  for (size_t i = 0; i < p.size(); ++i) {
    const auto &q = p[i], &r = p[(i + 1) % p.size()];
    a += q.first * r.second - r.first * q.second;
  }
  return 0.5 * std::abs(a);
}

std::string mm(double v) { return html::number(v, 3) + " mm"; }

// What happened since the last stage.
struct Deeds {
  std::string cuts;
  int fragments = 0, sorted = 0, plates = 0, unplated = 0, joined = 0;
  int hooks = 0, moves = 0, released = 0, sutures = 0, rows = 0, threads = 0, undone = 0, redone = 0;

  std::string text() const {
    std::string s = cuts;
    const auto add = [&](int n, const std::string& one, const std::string& many) {
      if (n > 0) s += (s.empty() ? "" : " ") + (n == 1 ? one : std::to_string(n) + many) + ".";
    };
    add(fragments, "One fragment moved", " fragments moved");
    add(sorted, "Fragments put together by their cut rings", " times fragments put together by their cut rings");
    add(plates, "One plate", " plates");
    add(unplated, "The plates on one fragment taken off", " times the plates on a fragment taken off");
    add(joined, "Two fragments joined", " pairs of fragments joined");
    add(hooks, "One hook set", " hooks set");
    if (moves > 0) s += s.empty() ? "The flap is moved with the hooks." : " The flap is moved with the hooks.";
    add(sutures, "One key suture", " key sutures");
    add(rows, "One row of sutures", " rows of sutures");
    add(threads, "One thread cut", " threads cut");
    if (released > 0) s += s.empty() ? "The hooks are taken out." : " The hooks are taken out.";
    add(undone, "One action taken back", " actions taken back");
    add(redone, "One action done again", " actions done again");
    return s;
  }
};

void note(const Json& j, const std::string& action, Deeds& d) {
  const auto cut = [&](const std::string& words) { d.cuts += (d.cuts.empty() ? "" : " ") + words + "."; };
  const double depth = word_number(j, "depth_mm"), angle = word_number(j, "angle_deg");
  const std::string deep = std::isfinite(depth) ? ", " + mm(depth) + " deep" : "";
  if (action == "excise")
    cut("Excision of " + html::number(area_mm2(points(j, "outline")), 3) + " mm²" + deep);
  else if (action == "incise")
    cut("Incision of " + mm(length_mm(points(j, "path"))) + deep +
        (std::isfinite(angle) && std::abs(angle - 90) > 0.5 ? ", blade at " + html::number(angle, 3) + "°" : ""));
  else if (action == "undermine")
    cut("Undermining of " + html::number(area_mm2(points(j, "outline")) / 100, 2) + " cm²" + deep);
  else if (action == "osteotomy")
    cut(j.contains("contour") ? "Osteotomy along a closed line" : "Osteotomy by a plane");
  else if (action == "connect_tissue")
    cut("Tissue between face and bone");
  else if (action == "move_fragment" || action == "let_go")
    ++d.fragments;
  else if (action == "sort")
    ++d.sorted;
  else if (action == "unplate")
    ++d.unplated;
  else if (action == "plate")
    ++d.plates;
  else if (action == "join")
    ++d.joined;
  else if (action == "hook")
    ++d.hooks;
  else if (action == "move")
    ++d.moves;
  else if (action == "release")
    ++d.released;
  else if (action == "suture")
    ++d.sutures;
  else if (action == "suture_corner")
    ++d.sutures;
  else if (action == "suture_row" || action == "suture_between")
    ++d.rows;
  else if (action == "cut_suture")
    ++d.threads;
  else if (action == "undo")
    ++d.undone;
  else if (action == "redo")
    ++d.redone;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> stage_words(const std::vector<std::string>& script) {
  std::vector<std::pair<std::string, std::string>> out;
  Deeds deeds;
  for (const std::string& line : script) {
    const Json j = Json::parse(line, nullptr, false);
    if (!j.is_object()) continue;
    const auto it = j.find("action");
    if (it == j.end() || !it->is_string()) continue;
    const std::string action = it->get<std::string>();
    if (action != "stage") {
      note(j, action, deeds);
      continue;
    }
    const auto name = j.find("name");
    out.emplace_back(name != j.end() && name->is_string() ? name->get<std::string>() : "", deeds.text());
    deeds = {};
  }
  return out;
}

}  // namespace limberg
