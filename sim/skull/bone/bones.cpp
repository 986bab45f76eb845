#include "sim/skull/bone/bones.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/field_hash.h"
#include "sim/base/hash.h"
#include "sim/skull/bone/held.h"
#include "sim/skull/bone/join.h"
#include "sim/skull/bone/shape.h"
#include "sim/skull/bone/words.h"

namespace limberg::bone {
namespace {

bool rigid(const Eigen::Isometry3d& p) {
  const Mat3 R = p.linear();
  return p.matrix().allFinite() && (R * R.transpose() - Mat3::Identity()).norm() < 1e-6 && R.determinant() > 0 &&
         p.translation().norm() < 1e5;
}

}  // namespace

Bones::Bones(std::vector<NamedMesh> bones, Workers& workers) : workers_(&workers) {
  if (bones.empty()) throw InputError("", 0, "there is no bone; at least one mesh was expected");
  for (NamedMesh& b : bones) {
    if (const auto fault = simplex::find_fault(b.mesh)) throw InputError("", 0, "bone " + b.name + ": " + *fault);
    std::vector<int32_t> of;
    const int32_t count = simplex::components(b.mesh, of);
    const std::vector<Bulk> bulk = bulks(b.mesh, of, count);
    simplex::Delta gone;
    for (int32_t c = 0; c < count; ++c)
      if (!(bulk[size_t(c)].volume_mm3 > 0))
        simplex::remove_component(b.mesh, int32_t(std::find(of.begin(), of.end(), c) - of.begin()), gone);
    simplex::compact(b.mesh);
    if (b.mesh.vertices() == 0)
      throw InputError(
          "", 0,
          "bone " + b.name +
              " is turned inside out; a surface with its faces counter-clockwise from outside was expected");
    const int32_t base = simplex::append(mesh_, b.mesh);
    const int32_t parts = simplex::components(b.mesh, of);
    for (int32_t c = 0; c < parts; ++c) {
      Fragment f;
      f.id = now_.next_id++, f.fixed = b.fixed;
      f.name = c == 0 ? b.name : b.name + " " + std::to_string(c + 1);
      f.vertex = base + int32_t(std::find(of.begin(), of.end(), c) - of.begin());
      now_.fragments.push_back(std::move(f));
    }
  }
  mesh_.before_mm = mesh_.x_mm;
  recount();
}

void Bones::recount() {
  shapes_.clear();
  const int32_t count = simplex::components(mesh_, component_);
  const std::vector<Bulk> bulk = bulks(mesh_, component_, count);
  id_of_component_.assign(size_t(count), -1);
  for (Fragment& f : now_.fragments) {
    const size_t c = size_t(component_[size_t(f.vertex)]);
    id_of_component_[c] = f.id;
    f.volume_mm3 = bulk[c].volume_mm3, f.centre_mm = bulk[c].centre_mm;
  }
}

int32_t Bones::index(int32_t id) const {
  for (size_t i = 0; i < now_.fragments.size(); ++i)
    if (now_.fragments[i].id == id) return int32_t(i);
  return -1;
}

const Fragment* Bones::fragment(int32_t id) const {
  const int32_t i = index(id);
  return i < 0 ? nullptr : &now_.fragments[size_t(i)];
}

int32_t Bones::fragment_of(int32_t v) const {
  return mesh_.alive(v) ? id_of_component_[size_t(component_[size_t(v)])] : -1;
}

Vec3 Bones::now_mm(int32_t v) const {
  const Fragment* f = fragment(fragment_of(v));
  return f ? Vec3(f->pose * mesh_.x_mm[size_t(v)]) : Vec3(Vec3::Zero());
}

int32_t Bones::nearest_fragment(const Vec3& rest, Vec3* on_bone) const {
  int32_t best = -1;
  double near = 1e300;
  for (const Fragment& f : now_.fragments) {
    const Bvh::Closest c = shape(f.id).surface.bvh.closest(rest, near);
    if (c.triangle >= 0 && c.distance_mm < near) {
      near = c.distance_mm, best = f.id;
      if (on_bone) *on_bone = c.point_mm;
    }
  }
  return best;
}

template <class Act>
std::string Bones::all_of(Act&& act) {
  simplex::Mesh mesh = mesh_;
  BonesState now = now_;
  try {
    return act();
  } catch (...) {
    mesh_ = std::move(mesh), now_ = std::move(now);
    ++version_;
    recount();
    throw;
  }
}

ActedOnBone Bones::finish(BoneChange&& change, std::string words) {
  try {
    change.after = now_;
  } catch (...) {
    take_back(change);
    throw;
  }
  return {{true, std::move(words)}, std::move(change)};
}

std::string Bones::cut_mesh(const Osteotomy& what, simplex::Delta& delta) {
  const int32_t at = index(what.fragment);
  const Fragment parent = now_.fragments[size_t(at)];
  const int32_t first_new = now_.next_id;
  const Cut cut = cut_bone(mesh_, parent.vertex, what, delta);
  if (!cut) return cut.reason;
  ++version_;
  // Pieces by their smallest vertex; the largest keeps the number.
  std::vector<int32_t> of;
  const int32_t count = simplex::components(mesh_, of);
  const std::vector<Bulk> bulk = bulks(mesh_, of, count);
  std::vector<int32_t> first(size_t(count), -1);
  for (int32_t v = mesh_.slots(); v-- > 0;)
    if (mesh_.alive(v)) first[size_t(of[size_t(v)])] = v;
  std::vector<uint8_t> other(size_t(count), 0);
  for (const Fragment& f : now_.fragments)
    if (f.id != parent.id) other[size_t(of[size_t(f.vertex)])] = 1;
  int32_t largest = -1;
  for (int32_t c = 0; c < count; ++c)
    if (!other[size_t(c)] && (largest < 0 || bulk[size_t(c)].volume_mm3 > bulk[size_t(largest)].volume_mm3))
      largest = c;
  now_.fragments[size_t(at)].vertex = first[size_t(largest)];
  const std::string root = parent.name.substr(0, parent.name.find(" piece"));
  for (int32_t c = 0; c < count; ++c) {
    if (other[size_t(c)] || c == largest) continue;
    Fragment f = parent;
    f.id = now_.next_id++, f.vertex = first[size_t(c)], f.fixed = false;
    f.name = root + " piece " + std::to_string(f.id);
    now_.fragments.push_back(std::move(f));
  }
  recount();
  // A plate stays on the piece that its end lies on.
  for (Plate& p : now_.plates)
    for (auto [id, x] : {std::pair(&p.a, &p.a_mm), std::pair(&p.b, &p.b_mm)}) {
      if (*id != parent.id) continue;
      double near = 1e300;
      for (const Fragment& f : now_.fragments) {
        if (f.id != parent.id && f.id < first_new) continue;
        const Bvh::Closest c = shape(f.id).surface.bvh.closest(*x, near);
        if (c.triangle >= 0 && c.distance_mm < near) near = c.distance_mm, *id = f.id;
      }
    }
  std::erase_if(now_.plates, [](const Plate& p) { return p.a == p.b; });
  return "";
}

ActedOnBone Bones::cut(const Osteotomy& asked) {
  if (hold_) return refused(kHeld);
  BoneChange change;
  change.kind = BoneChange::Kind::cut, change.what = asked, change.before = now_;
  if (asked.fragment >= 0 && index(asked.fragment) < 0) return refused(no_fragment(asked.fragment));
  if (asked.fragment < 0) {
    if (asked.kind == Osteotomy::Kind::contour && asked.path_mm.empty())
      return refused("a contour has at least three places");
    const Vec3 at = asked.kind == Osteotomy::Kind::contour ? asked.path_mm[0] : asked.point_mm;
    if (!at.allFinite()) return refused("a place of the cut is not finite");
    change.what.fragment = nearest_fragment(at);
  }
  const size_t fragments = now_.fragments.size();
  if (std::string bad = all_of([&] { return cut_mesh(change.what, change.delta); }); !bad.empty()) return refused(bad);
  return finish(std::move(change), now_.fragments.size() > fragments ? std::string() : kHangsTogether);
}

std::string Bones::join_mesh(BoneChange& join) {
  const int32_t a = join.a, b = join.b;
  std::vector<int32_t> seam;
  const int32_t ia = index(a), ib = index(b);
  const Fragment fa = now_.fragments[size_t(ia)], fb = now_.fragments[size_t(ib)];
  if (std::string bad = join_bones(mesh_, fa.vertex, fb.vertex, fa.pose.inverse() * fb.pose, join.delta, seam);
      !bad.empty())
    return bad;
  join.seam = smooth_seam(mesh_, seam, join.smooth_mm, *workers_, join.delta);
  ++version_;
  now_.fragments[size_t(ia)].vertex = std::min(fa.vertex, fb.vertex);
  now_.fragments.erase(now_.fragments.begin() + ib);
  find_vertex_of(a);  // it may have gone with a ring
  for (Plate& p : now_.plates) {
    const Eigen::Isometry3d to_a = fa.pose.inverse() * fb.pose;
    if (p.a == b) p.a = a, p.a_mm = to_a * p.a_mm;
    if (p.b == b) p.b = a, p.b_mm = to_a * p.b_mm;
  }
  std::erase_if(now_.plates, [](const Plate& p) { return p.a == p.b; });
  recount();
  return "";
}

ActedOnBone Bones::join(int32_t a, int32_t b, double smooth_mm) {
  if (hold_) return refused(kHeld);
  for (int32_t id : {a, b})
    if (index(id) < 0) return refused(no_fragment(id));
  if (a == b) return refused("two different fragments were expected");
  const bool fa = fragment(a)->fixed, fb = fragment(b)->fixed;
  if (fa && fb) return refused("both bones are fixed");
  if (fb || (!fa && b < a)) std::swap(a, b);
  BoneChange change;
  change.kind = BoneChange::Kind::join, change.a = a, change.b = b, change.smooth_mm = smooth_mm;
  change.before = now_;
  if (std::string bad = all_of([&] { return join_mesh(change); }); !bad.empty()) return refused(bad);
  const SeamReport s = change.seam;
  return finish(std::move(change), s.vertices > 0
                                       ? text("the seam is smoothed: %d places moved, by %.2f mm at most; the bone's "
                                              "volume kept to %.1g of it",
                                              int(s.vertices), s.farthest_mm, std::abs(s.volume_change))
                                       : std::string());
}

void Bones::find_vertex_of(int32_t id) {
  std::vector<int32_t> of;
  simplex::components(mesh_, of);
  std::vector<uint8_t> taken(mesh_.nbr.size() + 1, 0);
  for (const Fragment& g : now_.fragments)
    if (g.id != id) taken[size_t(of[size_t(g.vertex)])] = 1;
  for (int32_t v = 0; v < mesh_.slots(); ++v)
    if (mesh_.alive(v) && !taken[size_t(of[size_t(v)])]) {
      now_.fragments[size_t(index(id))].vertex = v;
      break;
    }
}

WorkedSurface Bones::work_mesh(BoneChange& w) {
  WorkedSurface done = work_surface(mesh_, fragment(w.worked)->vertex, w.work, *workers_, w.delta);
  if (!done.reason.empty()) return done;
  ++version_;
  find_vertex_of(w.worked);
  recount();
  return done;
}

ActedOnBone Bones::work(int32_t id, const SurfaceWork& what) {
  if (hold_) return refused(kHeld);
  if (index(id) < 0) return refused(no_fragment(id));
  BoneChange change;
  change.kind = BoneChange::Kind::work, change.work = what, change.worked = id, change.before = now_;
  std::string words;
  const std::string bad = all_of([&] {
    WorkedSurface done = work_mesh(change);
    words = std::move(done.words);
    return done.reason;
  });
  if (!bad.empty()) return refused(bad);
  return finish(std::move(change), std::move(words));
}

std::vector<int32_t> Bones::plated(int32_t id) const {
  std::vector<int32_t> ids{id};
  for (size_t i = 0; i < ids.size(); ++i)
    for (const Plate& p : now_.plates) {
      const int32_t other = p.a == ids[i] ? p.b : p.b == ids[i] ? p.a : -1;
      if (other >= 0 && std::find(ids.begin(), ids.end(), other) == ids.end()) ids.push_back(other);
    }
  std::sort(ids.begin(), ids.end());
  for (int32_t& k : ids) k = index(k);
  return ids;
}

ActedOnBone Bones::move(int32_t id, const Eigen::Isometry3d& pose) {
  if (hold_) return refused(kHeld);
  if (index(id) < 0) return refused(no_fragment(id));
  if (!rigid(pose)) return refused("a pose is a rotation and a finite translation");
  const std::vector<int32_t> group = plated(id);
  for (int32_t i : group)
    if (const Fragment& f = now_.fragments[size_t(i)]; f.fixed)
      return refused(f.id == id ? f.name + " is fixed" : "it is plated to " + f.name + ", which is fixed");
  BoneChange change;
  change.before = now_;
  const Eigen::Isometry3d by = pose * fragment(id)->pose.inverse();
  for (int32_t i : group) {
    Fragment& f = now_.fragments[size_t(i)];
    f.pose = f.id == id ? pose : by * f.pose;
  }
  return finish(std::move(change));
}

ActedOnBone Bones::plate(const Vec3& a, const Vec3& b) {
  if (hold_) return refused(kHeld);
  if (!a.allFinite() || !b.allFinite()) return refused("an end of the plate is not at a finite place");
  Plate p;
  p.a = nearest_fragment(a, &p.a_mm), p.b = nearest_fragment(b, &p.b_mm);
  constexpr double kFarthest_mm = 10;
  if ((p.a_mm - a).norm() > kFarthest_mm || (p.b_mm - b).norm() > kFarthest_mm)
    return refused("an end of the plate lies more than 10 mm from any bone");
  if (p.a == p.b)
    return refused("both ends of the plate lie on " + fragment(p.a)->name + "; two fragments were expected");
  BoneChange change;
  change.before = now_;
  now_.plates.push_back(p);
  return finish(std::move(change));
}

ActedOnBone Bones::unplate(int32_t id) {
  if (hold_) return refused(kHeld);
  if (index(id) < 0) return refused(no_fragment(id));
  BoneChange change;
  change.before = now_;
  if (std::erase_if(now_.plates, [&](const Plate& p) { return p.a == id || p.b == id; }) == 0)
    return refused("there is no plate on " + fragment(id)->name);
  return finish(std::move(change));
}

Outcome Bones::take_back(BoneChange& change) {
  if (hold_) return refused(kHeld);
  if (change.kind == BoneChange::Kind::state) {
    now_ = change.before;
    return {true, ""};
  }
  simplex::Delta delta = change.delta;
  all_of([&] {
    now_ = change.before;
    simplex::undo(mesh_, delta);
    ++version_;
    recount();
    return std::string();
  });
  change.delta = {};
  return {true, ""};
}

Outcome Bones::make_again(BoneChange& change) {
  if (hold_) return refused(kHeld);
  // The mesh is to the bit what it was when this was done first, so it can be done again and cannot fail.
  if (change.kind == BoneChange::Kind::state) {
    now_ = change.after;
    return {true, ""};
  }
  BoneChange again;
  again.a = change.a, again.b = change.b, again.smooth_mm = change.smooth_mm;
  again.work = change.work, again.worked = change.worked;
  all_of([&] {
    return change.kind == BoneChange::Kind::cut    ? cut_mesh(change.what, again.delta)
           : change.kind == BoneChange::Kind::join ? join_mesh(again)
                                                   : work_mesh(again).reason;
  });
  change.delta = std::move(again.delta);
  return {true, ""};
}

uint64_t Bones::hash() const {
  Hash64 h;
  h.add(simplex::hash(mesh_));
  for (const Fragment& f : now_.fragments) {
    h.add(f.id), h.add(f.name), h.add(f.vertex), h.add(f.fixed);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 4; ++j) h.add(f.pose.matrix()(i, j));
  }
  h.add(now_.next_id);
  for (const Plate& p : now_.plates) {
    h.add(p.a), h.add(p.b);
    for (int k = 0; k < 3; ++k) h.add(p.a_mm[k]), h.add(p.b_mm[k]);
  }
  return h.value();
}

uint64_t Bones::full_hash() const {
  FieldHash h;
  h(simplex::hash(mesh_), now_);
  return h.value();
}

}  // namespace limberg::bone
