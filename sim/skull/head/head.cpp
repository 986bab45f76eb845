#include "sim/skull/head/head.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/base/field_hash.h"
#include "sim/base/hash.h"
#include "sim/geometry/bvh.h"
#include "sim/skull/bone/words.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

// degrees of freedom whose free motions are counted exactly while somebody waits
constexpr int64_t kCountedAtOnce = 300;

Outcome refuse(std::string why) { return {false, std::move(why)}; }

int32_t nearest_vertex(const std::vector<Vec3>& x, const simplex::Mesh& mesh, const Vec3& p) {
  int32_t best = -1;
  double best2 = 1e300;
  for (int32_t v = 0; v < mesh.slots(); ++v) {
    if (!mesh.alive(v)) continue;
    const double d2 = (x[size_t(v)] - p).squaredNorm();
    if (d2 < best2) best2 = d2, best = v;
  }
  return best;
}

/// How a fragment lies to its neighbours, in words; empty: nothing gapes and nothing overlaps.
std::string lies(const bone::Bones& bones, int32_t id) {
  constexpr double kNothing_mm = 0.05;
  std::string words;
  for (const bone::Gap& g : bones.gaps()) {
    if ((g.a != id && g.b != id) || std::max(g.gap_max_mm, g.overlap_max_mm) < kNothing_mm) continue;
    words += (words.empty() ? "" : "; ") + bones.fragment(g.a == id ? g.b : g.a)->name +
             text(": gap %.1f mm, at most %.1f", g.gap_mean_mm, g.gap_max_mm);
    if (g.overlap_max_mm >= kNothing_mm)
      words += text(", overlap %.1f mm deep, %.0f mm^3", g.overlap_max_mm, g.overlap_mm3);
  }
  return words;
}

simplex::FaceModelSettings face_settings(std::vector<simplex::FaceBundle> muscles,
                                         std::vector<simplex::FaceSlide> slides) {
  simplex::FaceModelSettings s;
  s.elasticity.bundles = std::move(muscles), s.elasticity.slides = std::move(slides);
  if (!s.elasticity.slides.empty()) s.tolerance *= 0.1;  // soft tissue goes farther for what is left of the forces
  return s;
}

}  // namespace

Head::Head(HeadParts parts, Workers& workers)
    : workers_(workers),
      bones_(std::move(parts.bones), workers),
      face_(std::move(parts.face), workers, face_settings(std::move(parts.muscles), std::move(parts.slides))),
      face_iterations_(parts.face_iterations),
      state_{std::move(parts.landmarks), {}},
      colour_(std::move(parts.colour)),
      texture_(std::move(parts.texture)) {
  has_face_ = face_.face().vertices() > 0;
  for (HeadLandmark& l : state_.landmarks) {
    if (l.on_face && !has_face_)
      throw InputError("", 0, "landmark " + l.name + " lies on a face, and there is none; expected a face");
    tie(l);
  }
  first_landmarks_ = state_.landmarks;
  place_bones();
  for (const ConnectTissue& t : parts.tissues)
    if (const Outcome o = connect(t); !o.done)
      throw InputError("", 0, "tissue " + t.name + " cannot be connected: " + o.reason);
  topology_changed();
}

Head::~Head() = default;

ActedOnHead Head::act(const HeadCommand& command) {
  return std::visit([this](const auto& c) { return act(c); }, command);
}

// What follows the change of the bones, and the words of the answer; whatever is thrown there, the act is taken back.
template <class Rest>
ActedOnHead Head::finish(HeadChange& change, Rest&& rest) {
  try {
    std::string words = rest();
    return {{true, std::move(words)}, std::move(change)};
  } catch (...) {
    take_back(change);
    throw;
  }
}

// ---- acts on bone ----

ActedOnHead Head::act(const CutBone& c) {
  std::string reason;
  bone::Osteotomy o;
  o.kind = c.contour_mm.empty() ? bone::Osteotomy::Kind::plane : bone::Osteotomy::Kind::contour;
  o.path_mm = c.contour_mm, o.point_mm = c.point_mm, o.radius_mm = c.radius_mm, o.must_divide = c.must_divide;
  if (c.normal.norm() > 0) o.normal = c.normal.normalized();
  if (c.of && (o.fragment = find(*c.of, reason)) < 0) return refuse(reason);
  return cut(o);
}

ActedOnHead Head::act(const CutBoneByBlade& c) {
  std::string reason;
  bone::Osteotomy o;
  o.kind = bone::Osteotomy::Kind::fan;
  o.point_mm = c.corner_mm, o.ray = c.rays, o.radius_mm = c.reach_mm, o.must_divide = c.must_divide;
  if (c.of && (o.fragment = find(*c.of, reason)) < 0) return refuse(reason);
  return cut(o);
}

ActedOnHead Head::cut(const bone::Osteotomy& o) {
  HeadChange change = before(true);
  const uint64_t version = bones_.version();
  bone::ActedOnBone sawn = bones_.cut(o);
  if (!sawn.done) return Outcome(sawn);
  change.bones = std::move(sawn.change);
  return finish(change, [&] {
    bones_changed(version);
    // A cut through what a tissue hangs on is allowed; whoever made it is told.
    const std::string warning = has_face_ && !face_.warnings().empty() ? face_.warnings().back() : "";
    return sawn.reason + (sawn.reason.empty() || warning.empty() ? "" : "; ") + warning;
  });
}

ActedOnHead Head::act(const MoveFragment& m) {
  std::string reason;
  const int32_t id = find(m.fragment, reason);
  if (id < 0) return refuse(reason);
  HeadChange change = before(false);
  bone::ActedOnBone moved = bones_.move(id, isometry(m.by, centre_now(id)) * bones_.fragment(id)->pose);
  if (!moved.done) return Outcome(moved);
  change.bones = std::move(moved.change);
  return finish(change, [&] { return lies(bones_, id); });
}

namespace {

bool is_hand(int hand) { return hand >= 0 && size_t(hand) < kHands; }

}  // namespace

ActedOnHead Head::act(const GrabFragment& g) {
  if (!is_hand(g.hand)) return refuse("there is no hand " + std::to_string(g.hand));
  std::string reason;
  const int32_t id = find(g.fragment, reason);
  if (id < 0) return refuse(reason);
  if (grabbed_[size_t(g.hand)].fragment >= 0)
    return refuse("fragment " + std::to_string(grabbed_[size_t(g.hand)].fragment) + " is held already by this hand");
  Outcome done = bones_.grab(id);
  if (!done.done) return done;
  grabbed_[size_t(g.hand)] = {id, bones_.fragment(id)->pose, centre_now(id)};
  return done;
}

ActedOnHead Head::act(const DragFragment& d) {
  if (!is_hand(d.hand)) return refuse("there is no hand " + std::to_string(d.hand));
  const Grabbed& g = grabbed_[size_t(d.hand)];
  if (g.fragment < 0) return refuse("nothing is held by this hand; expected a grab before it");
  bones_.drag(g.fragment, isometry(d.to, g.centre_mm) * g.at);
  return {true, {}};
}

ActedOnHead Head::act(const LetGo& l) {
  if (!is_hand(l.hand)) return refuse("there is no hand " + std::to_string(l.hand));
  const int32_t id = grabbed_[size_t(l.hand)].fragment;
  if (id < 0) return refuse("nothing is held by this hand; expected a grab before it");
  HeadChange change = before(false);
  bone::ActedOnBone released = [&]() -> bone::ActedOnBone {
    try {
      return bones_.release(id, l.snap);
    } catch (const std::exception& e) {  // the hand holds on
      return Outcome(refuse(std::string("the fragment cannot be let go: ") + e.what()));
    }
  }();
  if (!released.done) return Outcome(released);
  grabbed_[size_t(l.hand)] = {}, change.bones = std::move(released.change);
  // Let go it is, however the words turn out: while another hand holds, nothing could be taken back.
  std::string words = released.reason;
  try {
    const std::string beside = lies(bones_, id);
    words += (words.empty() || beside.empty() ? "" : "; ") + beside;
  } catch (const std::exception& e) {
    words += (words.empty() ? "" : "; ") + std::string("how it lies cannot be told: ") + e.what();
  }
  return {{true, std::move(words)}, std::move(change)};
}

ActedOnHead Head::act(const PlateFragments& p) {
  HeadChange change = before(false);
  bone::ActedOnBone plated = bones_.plate(p.a_mm, p.b_mm);
  if (!plated.done) return Outcome(plated);
  change.bones = std::move(plated.change);
  return finish(change, [&] { return topology_changed(), plated.reason; });
}

ActedOnHead Head::act(const Unplate& u) {
  std::string reason;
  const int32_t id = find(u.fragment, reason);
  if (id < 0) return refuse(reason);
  HeadChange change = before(false);
  bone::ActedOnBone freed = bones_.unplate(id);
  if (!freed.done) return Outcome(freed);
  change.bones = std::move(freed.change);
  return finish(change, [&] { return topology_changed(), freed.reason; });
}

ActedOnHead Head::act(const SortFragments&) {
  HeadChange change = before(false);
  bone::ActedOnBone sorted = bones_.sort();
  if (!sorted.done) return Outcome(sorted);
  change.bones = std::move(sorted.change);
  return {Outcome(sorted), std::move(change)};
}

ActedOnHead Head::act(const JoinFragments& j) {
  std::string reason;
  const int32_t a = find(j.a, reason), b = a < 0 ? -1 : find(j.b, reason);
  if (a < 0 || b < 0) return refuse(reason);
  HeadChange change = before(true);
  const uint64_t version = bones_.version();
  std::vector<uint8_t> of[2];  // vertices of a and of b
  for (const int k : {0, 1}) {
    of[k].assign(size_t(bones_.mesh().slots()), 0);
    for (int32_t v = 0; v < bones_.mesh().slots(); ++v) of[k][size_t(v)] = bones_.fragment_of(v) == (k == 0 ? a : b);
  }
  const Eigen::Isometry3d pose_a = bones_.fragment(a)->pose, pose_b = bones_.fragment(b)->pose;
  bone::ActedOnBone joined = bones_.join(a, b, j.smooth_mm);
  if (!joined.done) return Outcome(joined);
  change.bones = std::move(joined.change);
  return finish(change, [&] {
    // The rest of the one that is gone was set anew; its landmarks go along.
    const bool a_stays = bones_.fragment(a) != nullptr;
    const Eigen::Isometry3d to = a_stays ? pose_a.inverse() * pose_b : pose_b.inverse() * pose_a;
    for (HeadLandmark& l : state_.landmarks)
      if (!l.on_face && l.fragment == (a_stays ? b : a)) l.X_mm = to * l.X_mm;
    if (has_face_) face_.rest_set_anew(of[a_stays ? 1 : 0], to);
    bones_changed(version);
    return joined.reason;
  });
}

// ---- work on the surface of a bone ----

ActedOnHead Head::act(const SplitFace& s) {
  return work(FragmentPick{-1, s.at_mm}, {bone::SurfaceWork::Kind::split_face, s.at_mm, s.at_mm, 0});
}
ActedOnHead Head::act(const MergeFaces& m) {
  return work(FragmentPick{-1, m.at_mm}, {bone::SurfaceWork::Kind::merge_faces, m.at_mm, m.at_mm, 0});
}
ActedOnHead Head::act(const SmoothSurface& s) {
  return work(FragmentPick{-1, s.at_mm}, {bone::SurfaceWork::Kind::smooth, s.at_mm, s.at_mm, s.radius_mm});
}
ActedOnHead Head::act(const PushSurface& p) {
  return work(p.of, {bone::SurfaceWork::Kind::push, p.from_mm, p.to_mm, p.radius_mm});
}

/// of: nothing, and it is the fragment nearest to where the work ends.
ActedOnHead Head::work(const std::optional<FragmentPick>& of, const bone::SurfaceWork& what) {
  std::string reason;
  const int32_t id = of ? find(*of, reason) : bones_.nearest_fragment(what.to_mm);
  if (id < 0) return refuse(reason.empty() ? "there is no bone; expected a head with some" : reason);
  HeadChange change = before(true);
  const uint64_t version = bones_.version();
  bone::ActedOnBone worked = bones_.work(id, what);
  if (!worked.done) return Outcome(worked);
  change.bones = std::move(worked.change);
  return finish(change, [&] {
    bones_changed(version);
    return worked.reason;
  });
}

// ---- acts on face and landmarks ----

namespace {

// of a region that columns cannot be laid under. Ears, nostrils and lids of a whole face are less (2026-11-27).
constexpr double kLeftOut = 0.25;

/// Those vertices of a region of the face that have bone near.
std::vector<int32_t> over_bone(const simplex::Mesh& face, std::vector<int32_t> region, const simplex::Mesh& bones) {
  const simplex::FanTriangles fan = simplex::fan_triangles(bones);
  const Bvh bvh(fan.X_mm, fan.tri);
  std::erase_if(region, [&](int32_t v) { return bvh.closest(face.x_mm[size_t(v)], kSkinOverBone_mm).triangle < 0; });
  return region;
}

}  // namespace

Outcome Head::connect(const ConnectTissue& t) {
  if (!has_face_) return refuse("there is no face; expected a head with one");
  for (const ConnectTissue& k : state_.tissues)
    if (k.name == t.name) return refuse("there is a tissue " + t.name + " already; expected another name");
  const simplex::Mesh& face = face_.face();
  simplex::FaceTissuePlan plan;
  plan.name = t.name;
  plan.layers = t.layers, plan.young_kPa = t.young_kPa, plan.mode = t.mode;
  plan.face_region = t.face_outline_mm.empty()
                         ? simplex::region_around(face, nearest_vertex(face.x_mm, face, t.face_mm), t.face_radius_mm)
                         : simplex::region_within(face, t.face_outline_mm);
  if (plan.face_region.empty())
    return refuse("no vertex of the face lies within face_outline; expected a wider line round a part of it");
  if (t.bone_radius_mm > 0) {
    for (int32_t v = 0; v < placed_.slots(); ++v)
      if (placed_.alive(v) && (placed_.x_mm[size_t(v)] - t.bone_mm).norm() <= t.bone_radius_mm)
        plan.skull_region.push_back(v);
    if (plan.skull_region.empty()) return refuse("there is no bone within bone_radius_mm of that place; expected some");
  }
  plan.floor = simplex::kSoundTissue;
  Outcome o = face_.connect(placed_, plan, &bones_.mesh());
  if (!o.done) {
    // A region that reaches a rim of the face, or skin under which there is no bone, ends before them; columns that are
    // thin, flat or folded are mended, or left out.
    plan.face_region = simplex::patch_of(face, over_bone(face, std::move(plan.face_region), placed_));
    plan.mend = true, plan.leave_out = kLeftOut;
    if (plan.face_region.empty()) return o;
    const Outcome mended = face_.connect(placed_, std::move(plan), &bones_.mesh());
    if (mended.done)
      o = {true, {}};
    else
      o.reason += "; " + mended.reason;
  }
  if (o.done) state_.tissues.push_back(t);
  return o;
}

ActedOnHead Head::act(const ConnectTissue& t) {
  if (bones_.holds(-1)) return refuse(bone::kHeld);
  HeadChange change = before(true);
  Outcome o{true, {}};
  ActedOnHead made = finish(change, [&]() -> std::string {
    o = connect(t);
    if (!o.done) return {};
    topology_changed();
    const bool net = t.mode == TissueKind::springs || t.mode == TissueKind::shape;
    return net ? face_.free_motions(face_.tissues().size() - 1, kCountedAtOnce) : std::string();
  });
  if (!o.done) return o;
  return made;
}

ActedOnHead Head::act(const Superpose& s) {
  constexpr size_t kMostMoments = 20;
  if (s.on != SkullBeside::off) {
    if (bones_.fragments().empty()) return refuse("there is no bone; expected a head with some");
    if (moments_.size() >= kMostMoments)
      return refuse("the skull was laid upon another 20 times already; expected fewer");
    place_bones();
    SkullMoment m;
    m.name = s.name.empty() ? std::to_string(moments_.size() + 1) : s.name;
    m.on = s.on;
    m.rest = !moments_.empty() && moment_version_ == bones_.version()
                 ? moments_.back().rest
                 : std::make_shared<const simplex::Mesh>(bones_.mesh());
    m.now_mm = placed_.x_mm;
    m.fragment.resize(placed_.x_mm.size());
    for (size_t v = 0; v < m.fragment.size(); ++v)
      m.fragment[v] = placed_.alive(int32_t(v)) ? bones_.fragment_of(int32_t(v)) : -1;
    for (const bone::Fragment& f : bones_.fragments()) m.names.emplace_back(f.id, f.name);
    moments_.push_back(std::move(m));
    moment_version_ = bones_.version();
  }
  beside_ = s.on;
  return {true, {}};
}

ActedOnHead Head::act(const PlaceLandmark& p) {
  if (p.on_face && !has_face_) return refuse("there is no face; expected \"on\":\"bone\"");
  HeadChange change = before(false);
  HeadLandmark l{p.name, p.at_mm, p.on_face, -1, -1};
  constexpr double kFarthest_mm = 20;
  if (p.on_face) {
    // On the face as it was at first, where scripts and files name places.
    const std::vector<Vec3>& X = face_.rest_mm();
    l.X_mm = X[size_t(nearest_vertex(X, face_.face(), p.at_mm))];
  } else if (bones_.nearest_fragment(p.at_mm, &l.X_mm) < 0) {
    return refuse("there is no bone; expected a place on bone");
  }
  if ((l.X_mm - p.at_mm).norm() > kFarthest_mm)
    return refuse("lies more than 20 mm from the " + std::string(p.on_face ? "face" : "bone") +
                  "; expected a place on it");
  tie(l);
  return finish(change, [&] {
    const auto same = std::find_if(state_.landmarks.begin(), state_.landmarks.end(),
                                   [&](const HeadLandmark& k) { return k.name == l.name; });
    if (same != state_.landmarks.end())
      *same = l;
    else
      state_.landmarks.push_back(l);
    topology_changed();
    return std::string();
  });
}

void Head::tie(HeadLandmark& l) const {
  if (l.on_face)
    l.vertex = nearest_vertex(face_.rest_mm(), face_.face(), l.X_mm);
  else
    l.fragment = bones_.nearest_fragment(l.X_mm);
}

Vec3 Head::landmark_mm(const HeadLandmark& l) const {
  if (l.on_face)
    return l.vertex < 0 ? l.X_mm
                        : Vec3(l.X_mm + face_.face().x_mm[size_t(l.vertex)] - face_.rest_mm()[size_t(l.vertex)]);
  const bone::Fragment* f = bones_.fragment(l.fragment);
  return f ? Vec3(f->pose * l.X_mm) : l.X_mm;
}

std::vector<std::pair<std::string, Vec3>> Head::landmarks_now() const {
  std::vector<std::pair<std::string, Vec3>> out;
  for (const HeadLandmark& l : state_.landmarks) out.emplace_back(l.name, landmark_mm(l));
  return out;
}

std::vector<std::pair<std::string, Vec3>> Head::landmarks_at_rest() const {
  std::vector<std::pair<std::string, Vec3>> out;
  for (const HeadLandmark& l : state_.landmarks) out.emplace_back(l.name, l.X_mm);
  return out;
}

// ---- what follows ----

int32_t Head::find(const FragmentPick& pick, std::string& reason) const {
  constexpr double kFarthest_mm = 15;
  if (pick.id >= 0) {
    if (bones_.fragment(pick.id)) return pick.id;
    reason = "there is no fragment " + std::to_string(pick.id) + "; expected one of";
    for (const bone::Fragment& f : bones_.fragments()) reason += " " + std::to_string(f.id) + " (" + f.name + ")";
    return -1;
  }
  Vec3 on = Vec3::Zero();
  const int32_t id = bones_.nearest_fragment(pick.at_mm, &on);
  if (id >= 0 && (on - pick.at_mm).norm() <= kFarthest_mm) return id;
  reason = "there is no bone within 15 mm of that place; expected a place on a fragment as it was at first";
  return -1;
}

Vec3 Head::centre_now(int32_t id) const {
  const bone::Fragment* f = bones_.fragment(id);
  return f->pose * f->centre_mm;
}

void Head::place_bones() {
  const simplex::Mesh& mesh = bones_.mesh();
  std::vector<Eigen::Isometry3d> poses;
  for (const bone::Fragment& f : bones_.fragments()) poses.push_back(f.pose);
  const bool mesh_changed = placed_version_ != bones_.version();
  const bool same = !mesh_changed && poses.size() == poses_.size() &&
                    std::equal(poses.begin(), poses.end(), poses_.begin(),
                               [](const auto& a, const auto& b) { return a.matrix() == b.matrix(); });
  if (same) return;
  if (mesh_changed) placed_ = mesh, placed_version_ = bones_.version();
  std::vector<int32_t> at;  // per fragment number, its place in the list
  for (size_t i = 0; i < poses.size(); ++i) {
    const auto id = size_t(bones_.fragments()[i].id);
    if (at.size() <= id) at.resize(id + 1, -1);
    at[id] = int32_t(i);
  }
  for (int32_t v = 0; v < mesh.slots(); ++v)
    if (mesh.alive(v))
      placed_.x_mm[size_t(v)] = poses[size_t(at[size_t(bones_.fragment_of(v))])] * mesh.x_mm[size_t(v)];
  poses_ = std::move(poses);
  if (has_face_) face_.follow(placed_);
}

HeadStep Head::step(double dt_s) {
  if (bones_.physics()) bones_.step(dt_s);
  place_bones();
  HeadStep out;
  if (has_face_) {
    const auto report = face_.step(face_iterations_);
    out.max_move_mm = report.max_move_mm;
    out.at_rest = report.at_rest;
  }
  if (bones_.holds(-1)) out.at_rest = false;
  ++steps_;
  return last_ = out;
}

void Head::bones_changed(uint64_t version_before) {
  if (bones_.version() == version_before) return;
  for (HeadLandmark& l : state_.landmarks)
    if (!l.on_face) tie(l);
  placed_version_ = 0;  // its numbers have changed
  if (has_face_) face_.rebind(bones_.mesh());
  place_bones();
  topology_changed();
}

void Head::topology_changed() {
  std::vector<std::string> names;
  for (const HeadLandmark& l : state_.landmarks) names.push_back(l.name);
  simplex::Mesh face = face_.face();
  face.x_mm = face_.rest_mm();
  view_.build(face, bones_, face_.tissues(), names, colour_, texture_.get());
}

void Head::fill(Snapshot& s) const {
  s.step = steps_;
  s.topology = view_.topology();
  s.topology_version = s.topology->version;
  view_.places(face_.face(), bones_, face_.tissues(), s.x_mm);
  s.field.clear();
  if (has_face_)
    view_.moved(face_.face(), s.x_mm, s.moved_mm);
  else
    s.moved_mm.clear();
  s.hooks.clear(), s.sutures.clear();
  s.plate_mm.clear();
  for (const bone::Plate& p : bones_.plates())
    s.plate_mm.push_back(
        {(bones_.fragment(p.a)->pose * p.a_mm).cast<float>(), (bones_.fragment(p.b)->pose * p.b_mm).cast<float>()});
  s.landmark_mm.clear();
  for (const HeadLandmark& l : state_.landmarks) s.landmark_mm.push_back(landmark_mm(l).cast<float>());
  s.figures.clear();
  if (has_face_)
    s.figures.push_back({"face moved, at most", "mm",
                         s.moved_mm.empty() ? 0 : *std::max_element(s.moved_mm.begin(), s.moved_mm.end())});
  for (const bone::Fragment& f : bones_.fragments()) {
    const double way = (f.pose * f.centre_mm - f.centre_mm).norm();
    if (way > 0) s.figures.push_back({f.name, "mm", float(way)});
  }
  s.residual = float(last_.at_rest ? 0 : last_.max_move_mm);
  s.distance_mm = float(last_.at_rest ? 0 : last_.max_move_mm);
}

uint64_t Head::topology_hash() const {
  Hash64 h;
  h.add(view_.topology()->hash);
  for (const bone::Fragment& f : bones_.fragments()) h.add(f.id), h.add(f.vertex);
  return h.value();
}

uint64_t Head::state_hash() const {
  Hash64 h;
  h.add(bones_.hash());
  if (has_face_) h.add(face_.hash());
  for (const HeadLandmark& l : state_.landmarks) {
    h.add(l.name), h.add(l.on_face);
    for (int i = 0; i < 3; ++i) h.add(l.X_mm[i]);
  }
  return h.value();
}

uint64_t Head::full_hash() const {
  FieldHash h;
  h(state_hash(), bones_.full_hash(), state_);
  return h.value();
}

// ---- back and forth ----

HeadChange Head::before(bool with_face) const {
  HeadChange c;
  c.state = state_;
  if (with_face && has_face_) c.face = std::make_unique<simplex::FaceModel>(face_);
  return c;
}

Outcome Head::take_back(HeadChange& change) {
  if (bones_.holds(-1)) return refuse(bone::kHeld);
  if (change.bones)
    if (Outcome o = bones_.take_back(*change.bones); !o.done) return o;
  try {
    swap_with(change);
  } catch (...) {
    if (change.bones) bones_.make_again(*change.bones);
    swap_with(change);
    throw;
  }
  return {true, {}};
}

Outcome Head::make_again(HeadChange& change) {
  if (bones_.holds(-1)) return refuse(bone::kHeld);
  if (change.bones)
    if (Outcome o = bones_.make_again(*change.bones); !o.done) return o;
  try {
    swap_with(change);
  } catch (...) {
    if (change.bones) bones_.take_back(*change.bones);
    swap_with(change);
    throw;
  }
  return {true, {}};
}

void Head::swap_with(HeadChange& change) {
  std::swap(state_, change.state);
  if (change.face) std::swap(face_, *change.face);
  placed_version_ = 0;
  place_bones();
  topology_changed();
}

}  // namespace limberg
