#include "app/window/live_measures.h"

#include <algorithm>

namespace limberg {

const std::vector<HeadMeasure>& LiveMeasures::read(const Snapshot& s) {
  if (!s.topology || s.topology->landmark.size() != s.landmark_mm.size()) return rows_;
  if (s.topology->version == version_ && s.landmark_mm == last_) return rows_;
  version_ = s.topology->version, last_ = s.landmark_mm;
  now_.clear();
  NamedPlaces before;
  for (size_t i = 0; i < last_.size(); ++i) {
    const std::string& name = s.topology->landmark[i];
    now_.emplace_back(name, last_[i].cast<double>());
    const auto known = std::find_if(first_.begin(), first_.end(), [&](const auto& p) { return p.first == name; });
    before.push_back(known == first_.end() ? now_.back() : *known);
  }
  first_ = before;  // one that is gone and comes again begins anew
  rows_ = head_measures(before, now_);
  return rows_;
}

}  // namespace limberg
