#include "app/patient/operations.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "sim/base/elementary.h"
#include "sim/base/error.h"
#include "sim/geometry/bvh.h"
#include "sim/skull/bone/bones.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/dual.h"

namespace limberg {

namespace {

// A genioplasty keeps 5 mm of bone below the canines' apices. These are laid in proportion: 27 mm long (Ash and Nelson,
// Wheeler's Dental Anatomy) in a jaw of 42 mm from the incisors' edge to the chin, and 3 mm behind Me's front-to-back
// place. Both 5 and 42 mm are as remembered from teaching, not looked up. Not less than 7 mm of bone for a plate.
constexpr double kCanine = 27.0 / 42, kBelowApices_mm = 5, kApicesBehind_mm = 3, kLeastChin_mm = 7, kMostChin_mm = 14;
constexpr double kChinFalls = 0.415;  // the cut against the lower border, on each mm backwards: nearly level
constexpr double kMove_s = 3, kRest_s = 1;
// A Le Fort I goes 5 mm above the roots' tips at least (Bell 1992); these end near the floor of the nose, the line from
// the spine in front to the one behind.
constexpr double kAboveFloor_mm = 5, kBehindPalate_mm = 2;
// The level cut of a split lies above the foramen, which is found .5 to .6 of the way down a ramus.
constexpr double kLevelOfRamus = 0.42;
constexpr double kBeforeRamus_mm = 12;   // the upright cut of a split, before the front edge of the ramus
constexpr double kBehindNasion_mm = 30;  // the upright cut behind the forehead, at the roofs of the orbits
constexpr double kBelowGlabella_mm = 8;  // lies the root of the nose, at least
// A Le Fort III: how far behind the suture the level cut and the upright one meet (behind the orbits' contents, before
// the base of the skull) and how far below it: the cut falls backwards, away from the brain.
constexpr double kBehindSuture_mm = 46, kFallsBackwards = 0.3, kOverSuture_mm = 2;
constexpr double kReach_mm = 180, kSplitReach_mm = 75;
constexpr double kAside_mm = 90;      // outside of any head
constexpr double kLeastShare = 0.85;  // of a ramus the plane of the split must lie in

/// As scripts have places; no -0.
Vec3 to_tenths(const Vec3& x) { return ((10 * x).array().round() / 10 + 0.).matrix(); }
Vec3 to_thousandths(const Vec3& x) { return ((1000 * x).array().round() / 1000 + 0.).matrix(); }

/// Head with bones only, for trying.
class Bench {
 public:
  Bench(const OperationGround& g, Workers& workers) : ground_(g), workers_(workers) {}

  std::optional<Vec3> at(const std::string& name) const {
    const FoundLandmark* l = find_landmark(ground_.landmarks, name);
    return l ? std::optional(l->at_mm) : std::nullopt;
  }
  const simplex::Mesh* bone(const std::string& name) const {
    for (const auto& [n, mesh] : ground_.bones)
      if (n == name) return &mesh;
    return nullptr;
  }
  /// The bones whole, one of them alone: its cuts know no other.
  bone::Bones whole(const std::string& name) const { return bone::Bones({{name, *bone(name), false}}, workers_); }

 private:
  const OperationGround& ground_;
  Workers& workers_;
};

/// The names that a plan needs and the head lacks, in words; empty: none.
std::string lacks(const Bench& b, const std::vector<std::string>& landmarks, const std::string& bone) {
  if (!b.bone(bone)) return "the head has no " + bone;
  std::string missing;
  for (const std::string& n : landmarks)
    if (!b.at(n)) missing += (missing.empty() ? "" : ", ") + n;
  return missing.empty() ? "" : "landmarks are missing: " + missing;
}

bone::Osteotomy osteotomy_of(const CutBoneByBlade& c) {
  bone::Osteotomy o;
  o.kind = bone::Osteotomy::Kind::fan, o.point_mm = c.corner_mm, o.ray = c.rays, o.radius_mm = c.reach_mm;
  o.fragment = 0;
  return o;
}

Command cut_line(const CutBoneByBlade& c) { return HeadCommand(c); }

Command move_line(const Vec3& at, const RigidMove& by) {
  MoveFragment m;
  m.fragment.at_mm = to_tenths(at), m.by = by, m.seconds = kMove_s;
  return HeadCommand(m);
}

Command rest_line() { return Wait{kRest_s}; }

RigidMove forwards(double mm) {
  RigidMove m;
  m.translation_mm = {0, mm, 0};
  return m;
}

std::string ahead(double mm) { return fmt::format("{:g} mm {}", std::abs(mm), mm < 0 ? "back" : "forwards"); }

Command way_stage(const std::string& what, double mm) { return Stage{what + (mm < 0 ? " back" : " forwards")}; }

Script script_of_lines(const std::string& note, std::vector<Command> lines) {
  Script s;
  s.header.note = note;
  for (Command& c : lines) s.lines.push_back({0, std::move(c)});
  return s;
}

/// Which places have to lie on one fragment, apart from those that have to lie on another.
struct Parted {
  std::vector<Vec3> moved, stays;
  double least_cm3 = 1;  // of the fragment that moves
};

/// Empty: the bones are parted as they should be.
std::string as_it_should(const bone::Bones& bones, const Parted& p) {
  const int32_t id = bones.nearest_fragment(p.moved.front());
  for (const Vec3& x : p.moved)
    if (bones.nearest_fragment(x) != id) return "the piece that is to be moved does not hold together";
  for (const Vec3& x : p.stays)
    if (bones.nearest_fragment(x) == id) return "the piece that is to be moved holds what should stay";
  if (const double cm3 = 1e-3 * bones.fragment(id)->volume_mm3; cm3 < p.least_cm3)
    return fmt::format("the piece that is to be moved has {:.1f} cm3", cm3);
  return "";
}

/// Tries offsets in turn until one is accepted; the reason of the first where none is.
template <class Try>
std::string first_accepted(const std::vector<Vec2>& offsets, Try&& attempt) {
  std::string first;
  for (const Vec2& o : offsets) {
    std::string why;
    try {
      why = attempt(o);
    } catch (const InputError& e) {  // a mesh that cannot be cut at all
      return e.what();
    }
    if (why.empty()) return "";
    if (first.empty()) first = why;
  }
  return first;
}

/// Nearest first: (0, 0), then rings of 1.5 mm.
std::vector<Vec2> offsets_mm() {
  std::vector<Vec2> all;
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) all.emplace_back(1.5 * i, 1.5 * j);
  std::stable_sort(all.begin(), all.end(),
                   [](const Vec2& a, const Vec2& b) { return a.squaredNorm() < b.squaredNorm(); });
  return all;
}

// ---- chin ----

PlannedOperation genioplasty(const Bench& b, double mm) {
  PlannedOperation p{"genioplasty", "Genioplasty: the chin is cut off and carried " + ahead(mm), {}, {}};
  if (p.why = lacks(b, {"Pog", "Me"}, "mandible"); !p.why.empty()) return p;
  const Vec3 me = *b.at("Me"), pog = *b.at("Pog");
  // What of the chin lies 5 mm below the roots, by a plane that comes out of the lower border below the premolars. The
  // piece is named by its lowest place.
  double border = 0.42;  // rises backwards by so much a mm: between Me and Go of the synthetic head
  const auto gr = b.at("Go_R"), gl = b.at("Go_L");
  if (gr && gl) {
    const Vec3 go = 0.5 * (*gr + *gl);
    if (me.y() - go.y() > 20) border = (go.z() - me.z()) / (me.y() - go.y());
  }
  const double slope = border - kChinFalls;
  double high_mm = 10;  // without incisors
  if (const auto ii = b.at("Ii"))
    high_mm = std::clamp((1 - kCanine) * (ii->z() - me.z()) - kBelowApices_mm * std::sqrt(1 + slope * slope) -
                             kApicesBehind_mm * std::max(0.0, slope),
                         kLeastChin_mm, kMostChin_mm);
  CutBone cut;
  std::vector<Vec2> up_or_down = offsets_mm();
  std::erase_if(up_or_down, [](const Vec2& off) { return off.y() != 0; });
  p.why = first_accepted(up_or_down, [&](const Vec2& off) -> std::string {
    cut.point_mm = to_tenths(Vec3(0, me.y(), me.z() + high_mm + off.x()));
    cut.normal = to_thousandths(Vec3(0, slope, 1).normalized()), cut.radius_mm = 32;
    bone::Osteotomy o;
    o.kind = bone::Osteotomy::Kind::plane;
    o.point_mm = cut.point_mm, o.normal = cut.normal, o.radius_mm = cut.radius_mm, o.fragment = 0;
    bone::Bones bones = b.whole("mandible");
    if (const auto done = bones.cut(o); !done.done) return done.reason;
    return as_it_should(bones, {{to_tenths(me), pog}, {}, 0.5});
  });
  if (!p.made()) return p;
  RigidMove along_cut;  // bone stays on bone
  along_cut.translation_mm = to_thousandths({0, mm, -slope * mm});
  p.script = script_of_lines(p.title, {Command(Stage{"before"}), Command(HeadCommand(cut)), Command(Stage{"chin cut"}),
                                       move_line(me, along_cut), rest_line(), way_stage("chin", mm)});
  return p;
}

// ---- maxilla ----

PlannedOperation le_fort_1(const Bench& b, double mm) {
  PlannedOperation p{
      "le_fort_1", "Le Fort I: the maxilla is cut free above its roots and carried " + ahead(mm), {}, {}};
  if (p.why = lacks(b, {"ANS", "PNS", "A", "Is", "N"}, "cranium"); !p.why.empty()) return p;
  const Vec3 ans = *b.at("ANS"), pns = *b.at("PNS");
  const Vec3 floor = Vec3(0, ans.y() - pns.y(), ans.z() - pns.z()).normalized(), up(0, -floor.z(), floor.y());
  CutBoneByBlade cut;
  cut.rays = {to_thousandths(floor), Vec3::UnitX(), to_thousandths(-up)}, cut.reach_mm = kReach_mm;
  p.why = first_accepted(offsets_mm(), [&](const Vec2& off) -> std::string {
    const Vec3 edge =
        Vec3(0, pns.y(), pns.z()) - (kBehindPalate_mm + off.y()) * floor + (kAboveFloor_mm + off.x()) * up;
    cut.corner_mm = to_tenths(edge - kAside_mm * Vec3::UnitX());
    bone::Bones bones = b.whole("cranium");
    if (const auto done = bones.cut(osteotomy_of(cut)); !done.done) return done.reason;
    return as_it_should(bones, {{*b.at("A"), ans, pns, *b.at("Is")}, {*b.at("N")}, 5});
  });
  if (!p.made()) return p;
  cut.of = FragmentPick{-1, to_tenths(*b.at("N"))};
  p.script = script_of_lines(p.title, {Command(Stage{"before"}), cut_line(cut), Command(Stage{"maxilla cut free"}),
                                       move_line(*b.at("A"), forwards(mm)), rest_line(), way_stage("maxilla", mm)});
  return p;
}

// ---- mandible ----

/// Where lines across (along x) go through one side of the mandible.
struct Ramus {
  const Bvh& at;
  double side;
  std::optional<Vec2> span(double y, double z) const {  // least and most |x|
    double low = 1e300, high = 0;
    for (const Bvh::LineHit& h : at.line(Vec3(side * 15, y, z), Vec3(side, 0, 0), 0, 80))
      low = std::min(low, 15 + h.t), high = std::max(high, 15 + h.t);
    if (high <= low) return std::nullopt;
    return Vec2(low, high);
  }
};

struct SplitPlan {
  CutBoneByBlade cut;
  double share = 0;  // of the lines through ramus and body behind the upright cut, whose bone the plane goes through
};

/// The split of one side; reason: why there is none.
std::optional<SplitPlan> plan_split(const Ramus& ramus, const Vec3& co, const Vec3& go, const Vec2& off,
                                    std::string& reason) {
  const double level = co.z() + kLevelOfRamus * (go.z() - co.z()) + off.x();
  // The front edge of the ramus, a little below that level.
  std::optional<double> front;
  for (double y = go.y() - 5; y < go.y() + 70; y += 0.5)
    if (ramus.span(y, level - 8)) front = y;
  if (!front) {
    reason = "no ramus is met at the level of the cut";
    return std::nullopt;
  }
  const double before = *front + kBeforeRamus_mm + off.y();
  // The middle between both tables: x = a + b y + c z by least squares.
  std::vector<std::pair<Vec3, Vec2>> seen;
  for (double y = go.y() + 2; y < before; y += 2)
    for (double z = go.z() + 4; z < level; z += 2)
      if (const auto s = ramus.span(y, z)) seen.push_back({Vec3(1, y, z), *s});
  if (seen.size() < 20) {
    reason = "too little of the ramus is in the picture";
    return std::nullopt;
  }
  Eigen::MatrixXd A(seen.size(), 3);
  Eigen::VectorXd x(seen.size());
  for (size_t i = 0; i < seen.size(); ++i) {
    A.row(Eigen::Index(i)) = seen[i].first.transpose();
    x[Eigen::Index(i)] = 0.5 * (seen[i].second.x() + seen[i].second.y());
  }
  const Vec3 abc = A.colPivHouseholderQr().solve(x);
  SplitPlan p;
  size_t within = 0;
  for (const auto& [yz, s] : seen) {
    const double at = abc.dot(yz);
    within += at > s.x() && at < s.y();
  }
  p.share = double(within) / double(seen.size());
  const double side = ramus.side;
  p.cut.corner_mm = to_tenths(Vec3(side * abc.dot(Vec3(1, before, level)), before, level));
  const Vec3 inwards(-side, 0, 0), backwards(-side * abc.y(), -1, 0), down(-side * abc.z(), 0, -1);
  p.cut.rays = {to_thousandths(inwards), to_thousandths(backwards), to_thousandths(down), to_thousandths(-inwards)};
  p.cut.reach_mm = kSplitReach_mm;
  return p;
}

PlannedOperation sagittal_split(const Bench& b, double mm) {
  PlannedOperation p{
      "sagittal_split", "Sagittal split of both sides: the tooth-bearing part is carried " + ahead(mm), {}, {}};
  if (p.why = lacks(b, {"Co_R", "Co_L", "Go_R", "Go_L", "Pog", "Ii"}, "mandible"); !p.why.empty()) return p;
  const simplex::FanTriangles fan = simplex::fan_triangles(*b.bone("mandible"));
  const Bvh bvh(fan.X_mm, fan.tri);
  const Vec3 pog = *b.at("Pog");
  std::vector<Command> lines{Command(Stage{"before"})};
  bone::Bones bones = b.whole("mandible");
  for (const auto& [side, words, name] :
       {std::tuple(1., "_R", "right side split"), std::tuple(-1., "_L", "left side split")}) {
    const Vec3 co = *b.at(std::string("Co") + words), go = *b.at(std::string("Go") + words);
    p.why = first_accepted(offsets_mm(), [&, side = side](const Vec2& off) -> std::string {
      std::string why;
      std::optional<SplitPlan> plan = plan_split({bvh, side}, co, go, off, why);
      if (!plan) return why;
      if (plan->share < kLeastShare)
        return fmt::format("a plane through the middle of the ramus leaves its bone at {:.0f} % of the places",
                           100 * (1 - plan->share));
      bone::Osteotomy o = osteotomy_of(plan->cut);
      o.fragment = bones.nearest_fragment(pog);
      bone::ActedOnBone done = bones.cut(o);
      if (!done.done) return done.reason;
      if (why = as_it_should(bones, {{pog, *b.at("Ii")}, {co}, 10}); !why.empty()) {
        bones.take_back(*done.change);
        return why;
      }
      plan->cut.of = FragmentPick{-1, to_tenths(pog)};
      lines.push_back(cut_line(plan->cut));
      return "";
    });
    if (!p.made()) {
      p.why = std::string(side > 0 ? "right" : "left") + " side: " + p.why;
      return p;
    }
    lines.push_back(Command(Stage{name}));
  }
  lines.push_back(move_line(pog, forwards(mm)));
  lines.push_back(rest_line());
  lines.push_back(way_stage("mandible", mm));
  p.script = script_of_lines(p.title, std::move(lines));
  return p;
}

PlannedOperation autorotation(const Bench& b, double deg) {
  const std::string words = fmt::format("{} by {:g} degrees", deg < 0 ? "closes" : "opens", std::abs(deg));
  PlannedOperation p{
      "autorotation", "Autorotation: the mandible " + words + " about the line through the condyles", {}, {}};
  if (p.why = lacks(b, {"Co_R", "Co_L", "Pog"}, "mandible"); !p.why.empty()) return p;
  const Vec3 r = *b.at("Co_R"), l = *b.at("Co_L");
  RigidMove m;
  m.rotation_deg = to_thousandths(-deg * (r - l).normalized()), m.about_mm = to_tenths(0.5 * (r + l));
  p.script = script_of_lines(
      p.title, {Command(Stage{"before"}), move_line(*b.at("Pog"), m), rest_line(), Command(Stage{"mandible turned"})});
  return p;
}

// ---- forehead ----

PlannedOperation fronto_orbital(const Bench& b, double mm) {
  PlannedOperation p{"fronto_orbital",
                     "Fronto-orbital advancement: forehead and upper rims of the orbits are carried " + ahead(mm),
                     {},
                     {}};
  if (p.why = lacks(b, {"N", "G", "ANS"}, "cranium"); !p.why.empty()) return p;
  const Vec3 n = *b.at("N"), g = *b.at("G"), ans = *b.at("ANS");
  std::vector<Vec3> stays{ans};
  for (const char* name : {"Or_R", "Or_L"})
    if (const auto x = b.at(name)) stays.push_back(*x);
  // On a forehead that lies back N is found too high: the root of the nose is below the glabella.
  const double level = std::min(n.z(), g.z() - kBelowGlabella_mm);
  CutBoneByBlade cut;
  // Level through the root of the nose and the sutures beside the orbits; behind, rising backwards by 20 degrees.
  cut.rays = {Vec3::UnitY(), Vec3::UnitX(), to_thousandths(Vec3(0, -0.342, 0.940))}, cut.reach_mm = kReach_mm;
  p.why = first_accepted(offsets_mm(), [&](const Vec2& off) -> std::string {
    cut.corner_mm = to_tenths(Vec3(-kAside_mm, n.y() - kBehindNasion_mm + off.y(), level + off.x()));
    bone::Bones bones = b.whole("cranium");
    if (const auto done = bones.cut(osteotomy_of(cut)); !done.done) return done.reason;
    return as_it_should(bones, {{g}, stays, 20});
  });
  if (!p.made()) return p;
  cut.of = FragmentPick{-1, to_tenths(ans)};
  p.script = script_of_lines(p.title, {Command(Stage{"before"}), cut_line(cut), Command(Stage{"forehead cut free"}),
                                       move_line(g, forwards(mm)), rest_line(), way_stage("forehead", mm)});
  return p;
}

// ---- midface ----

PlannedOperation le_fort_3(const Bench& b, double mm) {
  PlannedOperation p{"le_fort_3",
                     "Le Fort III: the midface with the lower rims of the orbits is cut free and carried " + ahead(mm),
                     {},
                     {}};
  if (p.why = lacks(b, {"N", "G", "ANS", "PNS", "A", "Is", "Or_R", "Or_L"}, "cranium"); !p.why.empty()) return p;
  const Vec3 n = *b.at("N"), g = *b.at("G"), pns = *b.at("PNS");
  std::vector<Vec3> moved{*b.at("A"), *b.at("ANS"), pns, *b.at("Is"), *b.at("Or_R"), *b.at("Or_L")};
  if (const auto x = b.at("Rhi")) moved.push_back(*x);
  std::vector<Vec3> stays{g};
  for (const char* name : {"Po_R", "Po_L", "Ba", "V"})
    if (const auto x = b.at(name)) stays.push_back(*x);
  // One step across the face: from the suture between nose and forehead through both orbits and their outer rims,
  // falling backwards; behind the orbits' floors down through both arches and the pterygoid region.
  const double suture = std::min(n.z(), g.z() - kBelowGlabella_mm) - kOverSuture_mm;
  const Vec3 level = Vec3(0, 1, kFallsBackwards).normalized();
  CutBoneByBlade cut;
  p.why = first_accepted(offsets_mm(), [&](const Vec2& off) -> std::string {
    const Vec3 suture_at(0, n.y(), suture + off.x());
    const Vec3 edge = suture_at - (kBehindSuture_mm + off.y()) / level.y() * level;
    // The upright cut passes behind the palate.
    const Vec3 down = Vec3(0, pns.y() - kBehindPalate_mm - edge.y(), pns.z() - edge.z());
    cut.rays = {to_thousandths(level), Vec3::UnitX(), to_thousandths(down.normalized())}, cut.reach_mm = kReach_mm;
    cut.corner_mm = to_tenths(edge - kAside_mm * Vec3::UnitX());
    bone::Bones bones = b.whole("cranium");
    if (const auto done = bones.cut(osteotomy_of(cut)); !done.done) return done.reason;
    return as_it_should(bones, {moved, stays, 20});
  });
  if (!p.made()) return p;
  cut.of = FragmentPick{-1, to_tenths(g)};
  p.script = script_of_lines(p.title, {Command(Stage{"before"}), cut_line(cut), Command(Stage{"midface cut free"}),
                                       move_line(*b.at("A"), forwards(mm)), rest_line(), way_stage("midface", mm)});
  return p;
}

using Planner = PlannedOperation (*)(const Bench&, double);
struct PlannedBy {
  KnownOperation about;
  Planner plan;
};
/// How far each is moved: usual amounts of a first plan, and what they may be.
constexpr PlannedBy kOperations[] = {
    {{"genioplasty", "the chin is cut off below the front teeth", "forwards_mm", 6, -10, 15}, genioplasty},
    {{"le_fort_1", "the maxilla is cut free above its roots", "forwards_mm", 6, -6, 12}, le_fort_1},
    {{"le_fort_3", "the midface with the lower rims of the orbits is cut free", "forwards_mm", 8, 1, 20}, le_fort_3},
    {{"sagittal_split", "both sides of the mandible are split", "forwards_mm", 6, -10, 12}, sagittal_split},
    {{"autorotation", "the mandible turns about its condyles and opens", "opens_deg", 10, -10, 25}, autorotation},
    {{"fronto_orbital", "the forehead is cut free with the upper rims of the orbits", "forwards_mm", 8, 1, 20},
     fronto_orbital}};

const PlannedBy& planned_by(std::string_view name) {
  for (const PlannedBy& k : kOperations)
    if (name == k.about.name) return k;
  throw InputError("", 0, "there is no operation on bone of that name; expected one of known_operations()");
}

}  // namespace

std::vector<KnownOperation> known_operations() {
  std::vector<KnownOperation> all;
  for (const PlannedBy& k : kOperations) all.push_back(k.about);
  return all;
}

PlannedOperation plan_operation(const OperationGround& ground, std::string_view name, double amount, Workers& workers) {
  return planned_by(name).plan(Bench(ground, workers), amount);
}

std::vector<PlannedOperation> plan_operations(const OperationGround& ground, Workers& workers) {
  std::vector<PlannedOperation> all;
  for (const PlannedBy& k : kOperations) {
    all.push_back(plan_operation(ground, k.about.name, k.about.usual, workers));
    all.back().script.header.scene = "patient";
  }
  return all;
}

}  // namespace limberg
