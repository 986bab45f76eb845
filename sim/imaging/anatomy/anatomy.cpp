#include "sim/imaging/anatomy/anatomy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/imaging/anatomy/ear_canal.h"
#include "sim/imaging/anatomy/landmark_search.h"

namespace limberg {

namespace {

constexpr double kAtlasBrain_mm[3] = {0, 0, 55};  // middle of the synthetic head's hollow (part_bones, 2026-11-27)
constexpr double kTilts_deg[] = {0, -15, 15, -30, 30};
// So much lower lies the middle of a hollow whose vault is not in the picture.
constexpr double kCut_mm[] = {0, 25, 50};
constexpr int kPatience = 40;         // shapes of two people: trimmed pairs change for ever, and the rest stays
constexpr double kPatch_mm = 30;      // of the synthetic head around a landmark
constexpr double kPatchMove_mm = 15;  // that it may go
constexpr double kMostScale = 0.2;    // heads of all ages from four years on are within it (head lengths, Farkas 1994)
constexpr double kMirror_mm = 15;     // bone so near a mirror image is its place
constexpr double kPorionsApart_mm = 15;  // forwards and upwards, of both together
constexpr int kFrameRounds = 3;

Mat3 about_x(double deg) {
  const double a = deg * M_PI / 180;
  Mat3 R = Mat3::Identity();
  R(1, 1) = R(2, 2) = elementary::cos(a), R(2, 1) = elementary::sin(a), R(1, 2) = -R(2, 1);
  return R;
}

struct Seeker {
  const AnatomySurfaces& patient;
  const HeadModel& atlas;
  Workers& workers;
  Anatomy out;
  Similarity skull_map, mandible_map;
  Bvh skull, mandible, skin;

  struct Named {
    std::string name;
    const LandmarkRule* rule;
    double side;
    Vec3 first_mm, at_mm;  // in the frame of the surfaces
    double flat_mm = 0;    // along the profile: so far it may lie from its place without that being seen
    bool met = false, from_canal = false, mirrored = false, as_laid = false;
  };
  std::vector<Named> named;

  Anatomy run() {
    lay();
    skull = Bvh(patient.skull.x_mm, patient.skull.tri);
    if (!patient.mandible.tri.empty()) mandible = Bvh(patient.mandible.x_mm, patient.mandible.tri);
    if (!patient.skin.tri.empty()) skin = Bvh(patient.skin.x_mm, patient.skin.tri);
    first_places();
    out.to_head = frame_of(skull_map.R.transpose());
    find_canals();
    for (int round = 0; round < kFrameRounds; ++round) {
      by_rule();
      out.to_head = frame_of(out.to_head.linear());
    }
    by_rule();
    finish();
    return std::move(out);
  }

  /// The patient's bone is moved: all of it has its like on the synthetic head; the picture may end below the vault.
  void lay() {
    const Surface whole = triangles_of(atlas.cranium);
    const SurfaceTarget model(whole);
    const Vec3 brain(kAtlasBrain_mm[0], kAtlasBrain_mm[1], kAtlasBrain_mm[2]);
    IcpSettings quick;
    quick.keep = 0.7, quick.samples = 2000, quick.iterations = 60, quick.patience = kPatience;
    double least = std::numeric_limits<double>::infinity();
    std::string reason = "no way was tried";
    Similarity best;
    for (const double tilt : kTilts_deg)
      for (const double cut : kCut_mm) {
        Similarity start;
        start.R = about_x(tilt), start.t_mm = patient.brain_mm - start.R * (brain - cut * Vec3::UnitZ());
        const IcpResult r = icp(patient.skull, model, start.inverse(), quick, workers);
        if (!r)
          reason = r.reason;
        else if (r.rms_mm < least)
          least = r.rms_mm, best = r.map;
      }
    if (!std::isfinite(least)) throw InputError("", 0, "no skull could be laid upon the bone: " + reason);
    out.skull_rms_mm = least;
    if (const IcpResult r = with_size(patient.skull, whole, best)) best = r.map, out.skull_rms_mm = r.rms_mm;
    mandible_map = skull_map = best.inverse();
    if (!patient.mandible.tri.empty())
      if (const IcpResult j = with_size(patient.mandible, triangles_of(atlas.mandible), best))
        mandible_map = j.map.inverse();
  }

  /// The patient's bone laid upon the synthetic one, sizes made alike. What is moved shrinks where shapes differ:
  /// nearest places lie nearer then (of a real head both ways differ by a seventh, 2026-11-30). So the size is the
  /// geometric mean of that of the one laid upon the other and of the other upon the one; with it, turn and shift are
  /// found again. Where no size within kMostScale comes of it, that of `start`.
  IcpResult with_size(const Surface& bone, const Surface& like, const Similarity& start) {
    const auto sound = [](const IcpResult& r) { return r && std::abs(r.map.scale - 1) <= kMostScale; };
    const SurfaceTarget model(like);
    IcpSettings s;
    s.keep = 0.7, s.samples = 8000, s.iterations = 200, s.patience = kPatience;
    IcpSettings growing = s;
    growing.with_scale = true;
    Similarity from = start;
    if (const IcpResult one = icp(bone, model, start, growing, workers); sound(one)) {
      from = one.map;
      if (const IcpResult other =
              icp(in_picture(like, bone, from.inverse()), SurfaceTarget(bone), from.inverse(), growing, workers);
          sound(other)) {
        const double grown = 1 / std::sqrt(from.scale * other.map.scale);  // about the middle of the bone
        Vec3 middle = Vec3::Zero();
        for (const Vec3& x : bone.x_mm) middle += from(x) / double(bone.x_mm.size());
        from.scale *= grown, from.t_mm = middle + grown * (from.t_mm - middle);
      }
    }
    return icp(bone, model, from, s, workers);
  }

  /// Places of the synthetic bone that lie where the patient's was in the picture.
  static Surface in_picture(const Surface& like, const Surface& bone, const Similarity& onto) {
    Eigen::AlignedBox3d box;
    for (const Vec3& x : bone.x_mm) box.extend(x);
    Surface out;
    for (const Vec3& x : like.x_mm)
      if (box.contains(onto(x))) out.x_mm.push_back(x);
    return out;
  }

  void first_places() {
    for (const LandmarkRule& r : landmark_rules())
      for (const double side : {1., -1.}) {
        if (!r.pair && side < 0) continue;
        const std::string name = r.pair ? std::string(r.name) + (side > 0 ? "_R" : "_L") : r.name;
        const bool jaw = r.surface == LandmarkRule::Surface::mandible;
        if (jaw ? mandible.empty() : r.surface == LandmarkRule::Surface::skin && skin.empty()) continue;
        const auto known = std::find_if(atlas.landmarks.begin(), atlas.landmarks.end(),
                                        [&](const auto& l) { return l.first == name; });
        if (known == atlas.landmarks.end()) continue;
        const Vec3 x = jaw || r.carried ? mandible_map(known->second) : skull_map(known->second);
        named.push_back({name, &r, side, x, x});
      }
    bring_nearer();
  }

  /// Around each landmark the synthetic head's surface is laid upon the patient's anew, alone: what lies elsewhere and
  /// is shaped otherwise has no say. Not where that would slip, or lead far away.
  void bring_nearer() {
    struct Pair {
      Surface model;
      std::optional<SurfaceTarget> target;
      Similarity map;
    };
    std::array<Pair, 3> pairs;  // skull, mandible, skin
    pairs[0] = {triangles_of(atlas.cranium), SurfaceTarget(patient.skull), skull_map};
    if (!mandible.empty()) pairs[1] = {triangles_of(atlas.mandible), SurfaceTarget(patient.mandible), mandible_map};
    if (!skin.empty()) pairs[2] = {triangles_of(atlas.face), SurfaceTarget(patient.skin), skull_map};
    IcpSettings s;
    s.keep = 0.7, s.iterations = 40, s.samples = 600;
    for (Named& n : named) {
      const Pair& p = pairs[size_t(n.rule->surface)];
      const Vec3 at = (n.rule->carried ? mandible_map : skull_map).inverse()(n.first_mm);
      Surface around{p.model.x_mm, {}};
      for (const Tri& t : p.model.tri)
        if ((p.model.x_mm[size_t(t[0])] - at).norm() < kPatch_mm) around.tri.push_back(t);
      const Surface patch = compacted(around);
      if (patch.tri.size() < 50) continue;
      const Similarity start = n.rule->carried ? mandible_map : p.map;
      const IcpResult r = icp(patch, *p.target, start, s, workers);
      if (r && (r.map(at) - n.first_mm).norm() < kPatchMove_mm) n.first_mm = n.at_mm = r.map(at);
    }
  }

  const Named* find(const std::string& name) const {
    const auto at = std::find_if(named.begin(), named.end(), [&](const Named& n) { return n.name == name; });
    return at == named.end() ? nullptr : &*at;
  }

  /// The frame with Frankfort's horizontal; `turn`: what it is nearly.
  Eigen::Isometry3d frame_of(const Mat3& turn) {
    IcpSettings s;
    s.samples = 6000, s.iterations = 100, s.patience = kPatience;
    Vec3 x = turn.row(0);
    const MirrorPlane plane = mirror_plane(patient.skull, x, s, workers);
    Vec3 through = Vec3::Zero();
    if (plane && std::abs(plane.normal.dot(x)) > 0.9) {
      x = plane.normal.dot(x) < 0 ? Vec3(-plane.normal) : plane.normal;
      through = plane.point_mm, out.symmetry_rms_mm = plane.rms_mm;
    } else {
      through = skull_map(Vec3(0, 0, 0));
    }
    const auto middle = [&](const char* a, const char* b) {
      const Named *l = find(a), *r = find(b);
      return l && r ? Vec3(0.5 * (l->at_mm + r->at_mm)) : skull_map(Vec3::Zero());
    };
    const Vec3 po = middle("Po_L", "Po_R"), orb = middle("Or_L", "Or_R");
    Vec3 y = orb - po;
    y = (y - x * x.dot(y)).normalized();
    Eigen::Isometry3d to = Eigen::Isometry3d::Identity();
    Mat3 R;
    R.row(0) = x, R.row(1) = y, R.row(2) = x.cross(y);
    const Vec3 origin = po - x * x.dot(po - through);
    to.linear() = R, to.translation() = -R * origin;
    return to;
  }

  /// In the volume the frame of the surfaces is turned by half a turn.
  void find_canals() {
    if (!patient.volume) return;
    const auto turned = [](const Vec3& x) { return Vec3(-x.x(), -x.y(), x.z()); };
    Mat3 head;
    for (Eigen::Index k = 0; k < 3; ++k) head.col(k) = turned(out.to_head.linear().row(k).transpose());
    std::array<Named*, 2> porion{};
    for (Named& n : named) {
      if (n.name != "Po_R" && n.name != "Po_L") continue;
      porion[n.side > 0] = &n;
      if (const auto canal =
              find_ear_canal(*patient.volume, patient.offset, patient.bone_HU, turned(n.first_mm), head, n.side))
        n.at_mm = turned(canal->porion_mm), n.met = n.from_canal = true, ++out.ear_canals;
    }
    if (out.ear_canals == 1) {  // the other one lies opposite to it, more surely than where the laid skull has it
      Named &seen = *porion[porion[1]->from_canal], &fellow = *porion[!porion[1]->from_canal];
      Vec3 place = out.to_head * seen.at_mm;
      place.x() = -place.x();
      fellow.first_mm = fellow.at_mm = out.to_head.inverse() * place, fellow.flat_mm = kMirror_mm / 2;
    }
    // They lie nearly opposite to one another: where they do not one of them is something else, and none is taken.
    if (out.ear_canals != 2) return;
    const Vec3 apart = out.to_head.linear() * (porion[1]->at_mm - porion[0]->at_mm);
    if (elementary::hypot(apart.y(), apart.z()) > kPorionsApart_mm)
      for (Named* n : porion) n->from_canal = false, n->at_mm = n->first_mm, out.ear_canals = 0;
  }

  const Bvh& ground(const Named& n) const {
    return n.rule->surface == LandmarkRule::Surface::skull      ? skull
           : n.rule->surface == LandmarkRule::Surface::mandible ? mandible
                                                                : skin;
  }
  LandmarkSearch search(const Named& n) const { return {ground(n), out.to_head, patient.voxel_mm}; }
  Vec3 laid_place(const Named& n) const {
    Vec3 place = out.to_head * n.first_mm;
    if (!n.rule->pair) place.x() = 0;  // in the plane of symmetry
    return place;
  }

  void by_rule() {
    const Eigen::Isometry3d back = out.to_head.inverse();
    for (Named& n : named) {
      const LandmarkRule& r = *n.rule;
      n.mirrored = false;
      if (n.from_canal) continue;
      // A rule that looks at one place only says nothing of its own: that of the laid skull is brought to the bone.
      const bool one_place = r.reach_mm[0] == 0 && r.reach_mm[1] == 0;
      if (one_place) {
        const Bvh::Closest c = ground(n).closest(n.first_mm, LandmarkSearch::kReach_mm);
        n.met = c.triangle >= 0;
        if (n.met) n.at_mm = c.point_mm, n.as_laid = true;
        continue;
      }
      const SoughtLandmark found = search(n).by_rule(r, laid_place(n), n.side);
      n.met = found.at_mm.has_value(), n.flat_mm = found.flat_mm, n.as_laid = found.as_laid;
      if (n.met) n.at_mm = back * *found.at_mm;
    }
    keep_order();
    for (Named& n : named) {
      if (n.met || !n.rule->pair) continue;
      const Named* fellow = find(n.name.substr(0, n.name.size() - 1) + (n.side > 0 ? "L" : "R"));
      if (!fellow || !fellow->met) continue;
      Vec3 place = out.to_head * fellow->at_mm;
      place.x() = -place.x();
      if (const Bvh::Closest c = ground(n).closest(back * place, kMirror_mm); c.triangle >= 0)
        n.at_mm = c.point_mm, n.met = n.mirrored = true;
    }
  }

  /// Along a profile landmarks follow one another from above, as their rules are listed. Of two that do not each goes
  /// where the laid skull has it: at the border of a picture, say, a rule has found the border.
  void keep_order() {
    static const std::vector<std::vector<const char*>> profiles = {
        {"G", "N", "Rhi", "ANS", "A", "Is"},
        {"Ii", "B", "Pog", "Gn"},
        {"g'", "n'", "prn", "sn", "ls", "sto", "li", "sl", "pog'", "gn'"}};
    const Eigen::Isometry3d back = out.to_head.inverse();
    const auto height = [&](const Named& n) { return (out.to_head * n.at_mm).z(); };
    for (const auto& profile : profiles) {
      std::vector<Named*> met, astray;
      for (Named& n : named)
        if (n.met && std::find(profile.begin(), profile.end(), n.name) != profile.end()) met.push_back(&n);
      for (size_t i = 1; i < met.size(); ++i)
        if (height(*met[i]) > height(*met[i - 1])) astray.insert(astray.end(), {met[i - 1], met[i]});
      for (Named* n : astray) {
        const SoughtLandmark laid = search(*n).as_laid(*n->rule, laid_place(*n), n->side);
        if (laid.at_mm) n->at_mm = back * *laid.at_mm;
        n->flat_mm = laid.flat_mm, n->as_laid = true;
      }
    }
  }

  void finish() {
    for (const Named& n : named) {
      if (!n.met) {
        out.missing.push_back(n.name);
        continue;
      }
      const double moved = n.mirrored ? kMirror_mm : n.from_canal ? 0 : (n.at_mm - n.first_mm).norm();
      const double unlike = n.as_laid ? out.skull_rms_mm : 0;  // off by as much as the shapes differ
      const double sd = std::sqrt(0.25 * patient.voxel_mm * patient.voxel_mm / 3 + moved * moved / 12 +
                                  n.flat_mm * n.flat_mm / 3 + unlike * unlike + 0.09);
      out.landmark.push_back(
          {n.name, out.to_head * n.at_mm, sd, n.rule->surface == LandmarkRule::Surface::skin, n.mirrored});
    }
    // The sella is a stated place of the synthetic head and lies on no surface that is sought.
    for (const auto& [name, at] : atlas.landmarks)
      if (name == "S")
        out.landmark.push_back(
            {"S", out.to_head * skull_map(at), elementary::hypot(3, out.skull_rms_mm), false, false});
    const Mat3& R = out.to_head.linear();
    out.yaw_deg = elementary::atan2(R(1, 0), R(1, 1)) * 180 / M_PI;
    out.pitch_deg = elementary::asin(std::clamp(R(2, 1), -1., 1.)) * 180 / M_PI;
    out.roll_deg = elementary::atan2(-R(2, 0), R(2, 2)) * 180 / M_PI;
  }
};

}  // namespace

Anatomy find_anatomy(const AnatomySurfaces& patient, const HeadModel& atlas, Workers& workers) {
  return Seeker{patient, atlas, workers, {}, {}, {}, {}, {}, {}, {}}.run();
}

}  // namespace limberg
