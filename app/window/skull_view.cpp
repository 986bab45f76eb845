#include "app/window/skull_view.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "app/head/skull_comparison.h"
#include "app/words/words.h"

namespace limberg {

namespace {

/// The bones of a snapshot as a surface, at rest or as they are; which vertex of the view each one is.
Surface bones_of(const Snapshot& s, bool at_rest, std::vector<int32_t>& of) {
  Surface out;
  of.clear();
  std::vector<int32_t> number(s.x_mm.size(), -1);
  const auto& tri = s.topology->view.tri;
  for (size_t t = 0; t < tri.size(); ++t) {
    if (s.topology->organ_of(t) != Organ::bone) continue;
    Tri k{};
    for (size_t c = 0; c < 3; ++c) {
      const size_t v = size_t(tri[t][c]);
      if (number[v] < 0)
        number[v] = int32_t(of.size()), of.push_back(int32_t(v)),
        out.x_mm.push_back(at_rest ? s.topology->view.X_mm[v] : Vec3(s.x_mm[v].cast<double>()));
      k[c] = number[v];
    }
    out.tri.push_back(k);
  }
  return out;
}

}  // namespace

const Snapshot* SkullView::show(SkullBeside with, const std::vector<std::string>& normal_files, const Snapshot& first,
                                const Snapshot& now) {
  if (with != with_) other_.reset(), shown_.reset(), measured_.clear(), with_ = with, word_.clear();
  if (with == SkullBeside::off || !now.topology) return nullptr;
  if (work_.valid() && work_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    Found f = work_.get();
    if (f.with == with) other_ = f.other;
    if (f.with != with) {
      measured_.clear();  // another one was asked for meanwhile
    } else if (!other_->reason.empty()) {
      word_ = other_->reason;
    } else {
      const std::string text = with == SkullBeside::normal
                                   ? fmt::format(english("{:.2f} mm rms from a normal skull"), f.rms_mm)
                                   : fmt::format(english("{:.2f} mm rms from its mirror image"), f.rms_mm);
      word_ = text, shown_ = std::move(f.shown);
    }
  }
  const bool failed = other_ && !other_->reason.empty();
  if (!other_) word_ = english("laying the skull upon the other ...");
  if (!work_.valid() && !failed && now.x_mm != measured_) {
    measured_ = now.x_mm;
    work_ = std::async(std::launch::async, [with, normal_files, before = first, s = now, other = other_,
                                            version = ++version_]() mutable {
      InlineWorkers w;
      std::vector<int32_t> of;
      if (!other) {
        const Surface rest = bones_of(before, true, of);
        if (with == SkullBeside::normal) {
          SkullFit fit = lay_upon_normal(rest, normal_files, w);
          if (!fit.target) fit.target.emplace(rest);
          other = std::make_shared<const Other>(Other{std::move(*fit.target), fit.map, fit.reason});
        } else {
          std::string reason;
          const Surface to = mirror_image(rest, reason, w);
          SurfaceTarget target(reason.empty() ? to : rest);
          const IcpResult r = reason.empty() ? icp(rest, target, {}, skull_fit(), w) : IcpResult{};
          other = std::make_shared<const Other>(Other{std::move(target), r.map, reason.empty() ? r.reason : reason});
        }
      }
      Found f;
      f.with = with, f.other = other;
      if (!other->reason.empty()) return f;
      const Surface bones = bones_of(s, false, of);
      const DistanceMap d = distance_map(bones, other->map, other->target, w);
      f.shown = coloured_skull(bones, d, version), f.rms_mm = d.rms_mm;
      return f;
    });
  }
  return shown_ ? &*shown_ : nullptr;
}

}  // namespace limberg
