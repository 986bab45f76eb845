#include "app/pictures/skin_fields.h"

#include <algorithm>
#include <cmath>

#include "app/words/words.h"
#include "render/overlay.h"
#include "sim/body/skin.h"
#include "sim/measure/perfusion.h"
#include "sim/measure/skin_strain.h"

namespace limberg {

const SkinFieldLook& look_of(SkinField field) {
  static constexpr SkinFieldLook kLooks[kSkinFields] = {
      {english("Skin"), "", ""},
      {english("Tension: stretch"), english("Skin stretch"), english("% of length"), ColourScale::magnitude, 1},
      {english("Least stretch"), english("Least stretch (below 0: folds)"), english("% of length"),
       ColourScale::signed_value, 1},
      {english("Change of area"), english("Skin area, change"), english("% of before"), ColourScale::signed_value, 1},
      {english("Stress"), english("Skin stress"), english("kPa"), ColourScale::magnitude, 1},
      {english("Height: dog-ears"), english("Height over the skin before"), english("mm"), ColourScale::signed_value,
       0.5},
      {english("Displacement"), english("Displacement"), english("mm"), ColourScale::magnitude, 1},
      {english("Perfusion risk"), english("Perfusion index (dark: at risk)"), english("1: attached"),
       ColourScale::magnitude, 1}};
  return kLooks[size_t(field) < size_t(kSkinFields) ? size_t(field) : 0];
}

namespace {

/// Means over the skin triangles around each vertex.
template <class Value>
void to_vertices(const SurfaceView& view, std::vector<float>& out, const Value& value_and_weight) {
  std::vector<float> weight(view.X_mm.size(), 0);
  out.assign(view.X_mm.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t) {
    if (view.kind[t] != FaceKind::skin) continue;
    const auto [value, w] = value_and_weight(t);
    if (!(w > 0) || !std::isfinite(value)) continue;
    for (const int32_t v : view.tri[t]) out[size_t(v)] += float(w * value), weight[size_t(v)] += float(w);
  }
  for (size_t v = 0; v < out.size(); ++v)
    if (weight[v] > 0) out[v] /= weight[v];
}

std::vector<uint8_t> skin_vertices(const SurfaceView& view) {
  std::vector<uint8_t> on(view.X_mm.size(), 0);
  for (size_t t = 0; t < view.tri.size(); ++t)
    if (view.kind[t] == FaceKind::skin)
      for (const int32_t v : view.tri[t]) on[size_t(v)] = 1;
  return on;
}

/// The end of the scale: a round number that at most 1 % of the places exceed.
void choose_scale(FieldShown& shown, const SkinFieldLook& look, const std::vector<uint8_t>& counts) {
  std::vector<float> size;
  float low = 0, high = 0;
  for (size_t v = 0; v < shown.value.size(); ++v)
    if (counts[v])
      size.push_back(std::abs(shown.value[v])), low = std::min(low, shown.value[v]),
                                                high = std::max(high, shown.value[v]);
  double end = look.least_end;
  if (!size.empty()) {
    const auto at = size.begin() + std::ptrdiff_t(0.99 * double(size.size() - 1));
    std::nth_element(size.begin(), at, size.end());
    end = std::max(end, double(*at));
  }
  const bool both = look.scale == ColourScale::signed_value;
  const double step = round_step(end, both ? 3 : 6);
  end = step * std::ceil(end / step - 1e-9);
  shown.lo = both ? -end : 0, shown.hi = end;
  shown.intervals = int(std::lround((shown.hi - shown.lo) / step));
  shown.above = double(high) > 1.001 * shown.hi, shown.below = double(low) < shown.lo - 0.001 * end;
}

}  // namespace

SkinFields::SkinFields() = default;
SkinFields::~SkinFields() = default;

const std::vector<MembraneState>& SkinFields::states(const Snapshot& s) {
  if (states_of_ != s.topology || states_at_mm_ != s.x_mm) {
    states_ = skin_states(s.topology->view, s.x_mm, *s.topology->body);
    states_of_ = s.topology, states_at_mm_ = s.x_mm;
  }
  return states_;
}

const FieldShown& SkinFields::show(SkinField field, const Snapshot& s) {
  shown_.value.clear();
  if (field == SkinField::none || !s.topology || s.x_mm.size() != s.topology->view.X_mm.size()) return shown_;
  const SurfaceView& view = s.topology->view;
  std::vector<uint8_t> counts = skin_vertices(view);
  const bool skin = std::find(counts.begin(), counts.end(), 1) != counts.end() && s.topology->body;
  if (!skin) {
    if (field != SkinField::moved || s.moved_mm.size() != s.x_mm.size()) return shown_;
    shown_.value = s.moved_mm;
    for (size_t t = 0; t < view.tri.size(); ++t)
      if (s.topology->organ_of(t) == Organ::face)
        for (const int32_t v : view.tri[t]) counts[size_t(v)] = 1;
    choose_scale(shown_, look_of(field), counts);
    return shown_;
  }
  const Body& body = *s.topology->body;
  switch (field) {
    case SkinField::stretch:
    case SkinField::least:
    case SkinField::stress: {
      const std::vector<MembraneState>& now = states(s);
      to_vertices(view, shown_.value, [&](size_t t) {
        const MembraneState& m = now[t];
        return std::pair(field == SkinField::stress
                             ? m.stress_kPa
                             : 100 * ((field == SkinField::stretch ? m.stretch : m.least_stretch) - 1),
                         m.area_mm2);
      });
      break;
    }
    case SkinField::area:
      to_vertices(view, shown_.value, [&](size_t t) {
        const auto& [a, b, c] = view.tri[t];
        const double rest =
            0.5 *
            (view.X_mm[size_t(b)] - view.X_mm[size_t(a)]).cross(view.X_mm[size_t(c)] - view.X_mm[size_t(a)]).norm();
        const double now =
            0.5 * double((s.x_mm[size_t(b)] - s.x_mm[size_t(a)]).cross(s.x_mm[size_t(c)] - s.x_mm[size_t(a)]).norm());
        return std::pair(rest > 1e-4 ? 100 * (now / rest - 1) : 0.0, rest > 1e-4 ? rest : 0.0);
      });
      break;
    case SkinField::height: {
      if (body_ != s.topology->body) body_ = s.topology->body, skin_ = std::make_unique<Skin>(body_);
      shown_.value.assign(s.x_mm.size(), 0);
      Bvh::Closest near;
      const Vec3 up = body.chart_normal();
      for (size_t v = 0; v < s.x_mm.size(); ++v)
        if (counts[v]) {
          const Vec3 x = s.x_mm[v].cast<double>();
          // The skin of a block is a plane.
          shown_.value[v] = float(body.is_box ? (x - body.chart_origin_mm).dot(up) : -skin_->depth_mm(x, near));
        }
      break;
    }
    case SkinField::moved:
      shown_.value.assign(s.x_mm.size(), 0);
      for (size_t v = 0; v < s.x_mm.size(); ++v)
        if (counts[v]) shown_.value[v] = (s.x_mm[v] - view.X_mm[v].cast<float>()).norm();
      break;
    case SkinField::perfusion:
      if (perfused_ != s.topology) {
        if (body_ != s.topology->body) body_ = s.topology->body, skin_ = std::make_unique<Skin>(body_);
        const std::vector<float> index = perfusion(view, *skin_).index;
        to_vertices(view, perfusion_, [&](size_t t) { return std::pair(double(index[t]), index[t] >= 0 ? 1.0 : 0.0); });
        perfused_ = s.topology;
      }
      shown_.value = perfusion_;
      break;
    default:
      break;
  }
  if (!shown_.value.empty()) choose_scale(shown_, look_of(field), counts);
  if (field == SkinField::perfusion)
    shown_.lo = 0, shown_.hi = 1, shown_.intervals = 5, shown_.above = shown_.below = false;
  return shown_;
}

}  // namespace limberg
