#pragma once
// A skull laid upon another: upon a normal one, or upon its own mirror image. What the operation has changed is read
// off the distance from there, before and after.
//
// The normal skull is the synthetic head of normal proportions (cache.h), or the surface that the scene names (the mean
// of several, say: `limberg superpose --average`). The fit is trimmed ICP of the skull as it was at first
// (sim/imaging/register/superposition.h): the places that differ most do not draw it, nor does the operation.
#include <optional>
#include <string>
#include <vector>

#include "app/result/result.h"
#include "render/view.h"
#include "sim/base/workers.h"
#include "sim/imaging/register/superposition.h"
#include "sim/skull/head/head.h"

namespace limberg {

struct SkullComparison {
  std::string with;               // in words
  Similarity map;                 // of the skull onto the other
  double fit_rms_mm = 0;          // of the pairs that count
  std::vector<Vec3> at_rest_mm;   // vertices of the skull's surface at first...
  std::vector<Vec3> now_mm;       // ...and now
  std::vector<int32_t> fragment;  // of each
  std::vector<Tri> tri;
  DistanceMap before, after;  // > 0: outside of the other
  std::string reason;         // why there is none
  explicit operator bool() const { return reason.empty(); }
};

/// The bones of a head as a surface: outside only matters to the eye, so cut faces are left out.
Surface bone_surface(const Head& head, bool at_rest, std::vector<int32_t>* fragment = nullptr);

/// A skull laid upon another, once; it can be measured there at several moments.
struct SkullFit {
  std::string with;  // in words
  std::optional<SurfaceTarget> target;
  Similarity map;
  double rms_mm = 0;   // of the pairs that count
  std::string reason;  // why there is none
};
/// `anywhere`: it may lie in any way, so four ways to begin are tried; else it begins as it lies.
SkullFit lay_upon(const Surface& skull, const Surface& other, const std::string& in_words, bool with_scale,
                  Workers& workers, bool anywhere = false);
/// Upon the normal skull: all of `files`, which together may lie in any way, or where there are none the built-in one.
/// A file that cannot be read is a reason.
SkullFit lay_upon_normal(const Surface& skull, const std::vector<std::string>& files, Workers& workers);
/// `rest` and `now` have the same vertices and triangles; `fragment`: of each vertex.
SkullComparison measure_on(const SkullFit& fit, Surface rest, Surface now, std::vector<int32_t> fragment,
                           Workers& workers);

SkullComparison compare_with(const Head& head, const Surface& other, const std::string& in_words, bool with_scale,
                             Workers& workers);
/// The skull of normal proportions, cranium and mandible.
Surface normal_skull(Workers& workers);
/// A skull's mirror image, in the plane of its own symmetry. Empty, with `reason` said: none was found.
Surface mirror_image(const Surface& skull, std::string& reason, Workers& workers);
/// How closely a skull is laid upon another.
IcpSettings skull_fit();
/// A snapshot of a surface alone, shown as this organ.
Snapshot snapshot_of(const Surface& surface, Organ organ, uint64_t version);
/// The same of a skull whose colour is the distance: drawn as a face is, since bone takes no colours.
Snapshot coloured_skull(const Surface& skull, const DistanceMap& distance, uint64_t version);

/// Both comparisons as `skull` {with, fit_rms_mm, before, after} and a table; maps as DIR/skull-normal.csv and
/// DIR/skull-mirror.csv and, where pictures can be made, in `gallery`. The moments that were asked for (Superpose) as
/// `skull_moments` {name, with, mean_mm, rms_mm, p95_mm}, a
/// table, a map DIR/skull-moment-1.csv and a picture each. A skull of fewer than 2000 vertices is only measured where
/// it was asked for. `normal_files`: lay_upon_normal. Returns what could not be compared, a sentence each.
std::vector<std::string> report_skull(Result& result, const Head& head, const std::vector<std::string>& normal_files,
                                      const std::string& dir, const Snapshot& last, const Camera& camera,
                                      Workers& workers);

}  // namespace limberg
