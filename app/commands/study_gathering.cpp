#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/commands/study_parts.h"

namespace limberg {

namespace {

void print_row(const study::Row& r, bool head) {
  if (head) {
    for (const auto& [name, v] : r.figures) std::printf("%*s ", std::max(9, int(name.size())), name.c_str());
    std::printf("\n");
  }
  for (const auto& [name, v] : r.figures)
    std::printf("%*s ", std::max(9, int(name.size())), fmt::format("{:.6g}", v).c_str());
  std::printf("\n");
  std::fflush(stdout);
}

std::optional<study::MemberResult> found(const MemberPlaces& at, const study::Family& f, const study::Values& v,
                                         std::string& dir) {
  for (const std::string& d : at.look)
    if (auto m = study::read_member(study::member_file(d, f, v, ".json"), f, v)) return dir = d, m;
  return std::nullopt;
}

}  // namespace

void Gathering::look(bool final) {
  for (; part_ < parts_.size(); ++part_, member_ = 0, head_ = true) {
    study::Gathered& g = parts_[part_];
    for (; member_ < g.members.size(); ++member_) {
      const Key key{part_, member_};
      const bool there = !missing.contains(key), over = final || given_up.contains(key);
      if (!there && !over) return;
      std::string dir;
      const auto m = there ? found(at_, *g.family, g.members[member_], dir) : std::nullopt;
      if (!m || !m->failure.empty()) {
        const std::string why = m ? m->failure : reason.contains(key) ? reason.at(key) : "";
        if (!why.empty()) g.failed.push_back({study::member_name(*g.family, g.members[member_]), why});
        continue;
      }
      g.rows.push_back(m->row);
      g.row_of.push_back(member_);
      if (part_ == 0) pictures_.push_back(study::member_file(dir, *g.family, g.members[member_], ".png"));
      if (print_) print_row(g.rows.back(), head_);
      head_ = false;
    }
  }
}

}  // namespace limberg
