// The view after a cut, from the view before.
//
//   triangles  those of sided faces that are gone leave their numbers to the new ones
//   vertices   every orbit that has changed has a corner of a new
//              face, so the orbits of these are walked. An orbit
//              keeps a number when it has all corners that are left
//              to it; else its corners get a new one: first the
//              numbers that no corner has any more, then further ones
#include "sim/cutting/arrangement/surface_view_update.h"

#include <algorithm>

#include "sim/base/number_set.h"

namespace limberg {
namespace {

class Follow {
 public:
  Follow(const ArrangementStore& s, const Arrangement& a, const SurfaceView& before, SurfaceView& view,
         ViewChange& change)
      : s_(s),
        a_(a),
        read_(s, a),
        before_(before),
        view_(view),
        now_(view),
        change_(change),
        faces_then_(int32_t(before.triangle_of.size() / 2)) {}

  bool run(int32_t operations_then) {
    view_ = before_;
    if (!triangles(operations_then)) return false;
    for (int32_t sided : fresh_)
      for (int i = 0; i < 3; ++i)
        if (int32_t corner = 3 * sided + i; !seen_[size_t(corner - 6 * faces_then_)]) find_orbit(corner);
    if (!number_vertices()) return false;
    rims();
    sort_unique(change_.vertices, now_.X_mm.size());
    sort_unique(change_.triangles, now_.tri.size());
    return true;
  }

 private:
  struct Orbit {
    size_t begin = 0, end = 0;  // into corner_
    int32_t vertex = -1;        // the number that it keeps
  };
  bool triangles(int32_t operations_then);
  void find_orbit(int32_t corner);
  bool number_vertices();
  void rims();
  void lose(int32_t v, int32_t corners) {
    if ((view_.corners[size_t(v)] -= corners) == 0) freed_.push_back(v);
  }
  int32_t vertex_at(int32_t corner) const {
    const int32_t sided = corner / 3;
    return now_.tri[size_t(now_.triangle_of[size_t(sided)])][size_t(ViewReader::corner_in_view(sided, corner % 3))];
  }

  const ArrangementStore& s_;
  const Arrangement& a_;
  ViewReader read_;
  const SurfaceView& before_;
  SurfaceView& view_;
  const SurfaceView& now_;  // view_, for reading
  ViewChange& change_;
  int32_t faces_then_;
  std::vector<int32_t> fresh_;  // new sided faces
  std::vector<uint8_t> seen_;   // per corner of a new face
  std::vector<int32_t> corner_, freed_;
  std::vector<Orbit> orbit_;
  std::vector<std::pair<int32_t, int32_t>> share_;  // of the orbit at hand: old vertex, corners
};

bool Follow::triangles(int32_t operations_then) {
  const int32_t faces = int32_t(s_.face.size());
  if (faces < faces_then_ || size_t(operations_then) > s_.history.size()) return false;
  std::vector<int32_t> free;
  const auto look_at = [&](int32_t f) {
    for (int side = 0; f < faces_then_ && side < 2; ++side) {
      const int32_t sided = sided_face(f, side), t = now_.triangle_of[size_t(sided)];
      if (t < 0 || s_.face[f].has_side(side)) continue;
      free.push_back(t);
      view_.triangle_of[size_t(sided)] = -1;
      for (int32_t v : now_.tri[size_t(t)]) lose(v, 1);
    }
  };
  // The last operation of that time may have gone on since: debris is swept as a part of it.
  for (size_t i = size_t(std::max(0, operations_then - 1)); i < s_.history.size(); ++i) {
    for (int32_t f : s_.history[i].retired) look_at(f);
    for (const auto& m : s_.history[i].mat) look_at(m.first);
  }
  std::sort(free.begin(), free.end());
  for (int32_t f = faces_then_; f < faces; ++f)
    for (int side = 0; side < 2; ++side)
      if (s_.face[f].has_side(side)) fresh_.push_back(sided_face(f, side));
  if (fresh_.size() < free.size()) return false;
  seen_.assign(size_t(6 * (faces - faces_then_)), 0);
  view_.triangle_of.resize(size_t(2 * faces), -1);
  size_t reused = 0;
  int32_t last_face = -1;
  std::array<Eigen::Vector2f, 3> uv;
  for (int32_t sided : fresh_) {
    const Face& face = s_.face[sided / 2];
    if (sided / 2 != last_face) uv = read_.uv(face), last_face = sided / 2;
    const FaceKind kind = read_.kind(face.orig);
    const int32_t origin = read_.origin(face.orig);
    const auto its_uv = ViewReader::in_view(sided, uv);
    int32_t t = int32_t(now_.tri.size());
    if (reused < free.size()) {
      t = free[reused++];
      view_.uv[size_t(t)] = its_uv;
      view_.kind.set(size_t(t), kind);
      view_.sided_face[size_t(t)] = sided;
      view_.origin.set(size_t(t), origin);
    } else {
      view_.tri.push_back({});
      view_.uv.push_back(its_uv);
      view_.kind.push_back(kind);
      view_.sided_face.push_back(sided);
      view_.origin.push_back(origin);
      view_.rim.push_back(0);
    }
    view_.triangle_of[size_t(sided)] = t;
    change_.triangles.push_back(t);
  }
  return true;
}

void Follow::find_orbit(int32_t corner) {
  Orbit orbit;
  orbit.begin = corner_.size();
  share_.clear();
  read_.orbit(corner, [&](int32_t at) {
    corner_.push_back(at);
    if (at >= 6 * faces_then_) {
      seen_[size_t(at - 6 * faces_then_)] = 1;
      return;
    }
    const int32_t v = vertex_at(at);
    for (auto& s : share_)
      if (s.first == v) {
        ++s.second;
        return;
      }
    share_.push_back({v, 1});
  });
  orbit.end = corner_.size();
  for (const auto& [v, corners] : share_) {
    if (orbit.vertex < 0 && now_.corners[size_t(v)] == corners)
      orbit.vertex = v;
    else
      lose(v, corners);
  }
  if (orbit.vertex >= 0) view_.corners.set(size_t(orbit.vertex), int32_t(orbit.end - orbit.begin));
  orbit_.push_back(orbit);
}

bool Follow::number_vertices() {
  // Who has lost all corners that were there may have been kept
  // by an orbit of new ones only at its own place: no such one.
  std::sort(freed_.begin(), freed_.end());
  size_t reused = 0, wanted = 0;
  for (const Orbit& o : orbit_) wanted += o.vertex < 0;
  if (wanted < freed_.size()) return false;
  for (const Orbit& o : orbit_) {
    int32_t v = o.vertex;
    const int32_t corners = int32_t(o.end - o.begin), first = corner_[o.begin];
    const int32_t point = s_.face[first / 6].v[size_t(first % 3)];
    if (v < 0 && reused < freed_.size()) {
      v = freed_[reused++];
      view_.X_mm.set(size_t(v), a_.point_mm(point));
      view_.point.set(size_t(v), point);
      view_.corners[size_t(v)] = corners;
    } else if (v < 0) {
      v = int32_t(now_.X_mm.size());
      view_.X_mm.push_back(a_.point_mm(point));
      view_.point.push_back(point);
      view_.corners.push_back(corners);
    }
    change_.vertices.push_back(v);
    for (size_t i = o.begin; i < o.end; ++i) {
      const int32_t sided = corner_[i] / 3, t = now_.triangle_of[size_t(sided)];
      const size_t k = size_t(ViewReader::corner_in_view(sided, corner_[i] % 3));
      if (now_.tri[size_t(t)][k] == v) continue;
      view_.tri[size_t(t)][k] = v;
      if (sided < 2 * faces_then_) change_.triangles.push_back(t);
    }
  }
  return true;
}

void Follow::rims() {
  const auto again = [&](int32_t sided) {
    const size_t t = size_t(now_.triangle_of[size_t(sided)]);
    if (const uint8_t rim = read_.rim(sided); now_.rim[t] != rim) {
      view_.rim[t] = rim;
      change_.triangles.push_back(int32_t(t));
    }
  };
  for (int32_t sided : fresh_) {
    again(sided);
    for (int k = 0; k < 3; ++k)
      if (const int32_t m = s_.mate[sided / 2][size_t(3 * (sided % 2) + k)]; m >= 0 && m / 3 < 2 * faces_then_)
        again(m / 3);
  }
}

}  // namespace

bool follow_view(const ArrangementStore& s, const Arrangement& a, const SurfaceView& before, int32_t operations_then,
                 SurfaceView& view, ViewChange& change) {
  return Follow(s, a, before, view, change).run(operations_then);
}

}  // namespace limberg
