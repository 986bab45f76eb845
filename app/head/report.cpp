#include "app/head/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "app/head/measures.h"
#include "app/head/skull_comparison.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/schema.h"
#include "app/result/tables.h"
#include "sim/commands/script.h"
#include "sim/skull/bone/sorting.h"

namespace limberg {

namespace {

double turned_deg(const Eigen::Isometry3d& pose) {
  return Eigen::AngleAxisd(pose.linear()).angle() * 180 / std::numbers::pi;
}

struct Moved {
  double most_mm = 0, mean_mm = 0;  // mean: of the places that moved by more than 0.1 mm
  int64_t places = 0;
};

Moved face_moved(const Head& head) {
  Moved m;
  const simplex::Mesh& face = head.face();
  const std::vector<Vec3>& X = head.face_model().rest_mm();
  for (int32_t v = 0; v < face.slots(); ++v) {
    if (!face.alive(v)) continue;
    const double d = (face.x_mm[size_t(v)] - X[size_t(v)]).norm();
    m.most_mm = std::max(m.most_mm, d);
    if (d > 0.1) m.mean_mm += d, ++m.places;
  }
  if (m.places > 0) m.mean_mm /= double(m.places);
  return m;
}

std::string name_of(const Head& head, int32_t id) {
  const bone::Fragment* f = head.bones().fragment(id);
  return f ? f->name : std::to_string(id);
}

std::string tenth(double v) { return fmt::format("{:.1f}", v); }
std::string change(double v) { return fmt::format("{:+.2f}", std::round(100 * v) / 100 + 0.0); }

/// What head_measures finds, as rows of the report; one group in each table.
ResultTable measure_table(Result& r, const std::vector<HeadMeasure>& all, HeadMeasure::Group group, const char* key,
                          const char* title, const char* about) {
  ResultTable t;
  t.title = title, t.about = about;
  t.columns = {"figure", "before", "after", "change", "unit", "norm"};
  int n = 0;
  for (const HeadMeasure& m : all) {
    if (m.group != group) continue;
    const std::string p = std::string("/head/") + key + "/" + std::to_string(n++);
    r.set(p + "/name", m.name), r.set(p + "/unit", m.unit), r.set(p + "/before", m.before), r.set(p + "/after", m.now);
    t.rows.push_back({m.name, tenth(m.before), tenth(m.now), change(m.change()), m.unit, m.norm});
  }
  return t;
}

/// The middle of the forehead from the sella, where a scene names it.
void add_forehead(Result& r, const Head& head, ResultTable& t) {
  const auto at = [](const NamedPlaces& l, const std::string& name) -> std::optional<Vec3> {
    for (const auto& [k, x] : l)
      if (k == name) return x;
    return std::nullopt;
  };
  const NamedPlaces was = head.landmarks_at_rest(), is = head.landmarks_now();
  for (const auto& [name, words] : {std::pair("F", "S-F, frontal bone"), std::pair("f'", "S-f', forehead")})
    if (at(was, "S") && at(was, name)) {
      const double a = (*at(was, "S") - *at(was, name)).norm(), b = (*at(is, "S") - *at(is, name)).norm();
      const std::string p = "/head/cephalometry/" + std::to_string(t.rows.size());
      r.set(p + "/name", words), r.set(p + "/unit", "mm"), r.set(p + "/before", a), r.set(p + "/after", b);
      t.rows.push_back({words, tenth(a), tenth(b), change(b - a), "mm", ""});
    }
}

/// Which fragments fit each other by their cut rings, and for each pair the line of a script that puts it together.
ResultTable fits(Result& r, const Head& head) {
  ResultTable t;
  t.title = "Fragments that fit each other";
  t.about =
      "Found by their cut rings, wherever they lie, and verified (sim/skull/bone/sorting.h); how to move the second "
      "one so "
      "that it fits the first where that is now (one of them at a time: \"sort\" in a script puts all of them "
      "together). Those that would have fitted are named with the reason.";
  t.columns = {"fragments", "rings together, mm", "residual, mm", "right, mm", "forward, mm",
               "up, mm",    "turned, degrees"};
  if (head.bones().fragments().size() < 2) return t;
  std::vector<int32_t> ids;
  const bone::Sorting found = bone::sort_fragments(bone::pieces_of(head.bones(), &ids));
  int n = 0;
  for (const bone::Match& m : found.matches) {
    // A bone that is fixed stays; else the first of the two.
    const bool first_moves = head.bones().fragment(ids[size_t(m.b)])->fixed;
    const int32_t stays = ids[size_t(first_moves ? m.b : m.a)], moves = ids[size_t(first_moves ? m.a : m.b)];
    const Eigen::Isometry3d by = first_moves ? m.b_in_a.inverse() : m.b_in_a;
    const bone::Fragment& f = *head.bones().fragment(moves);
    const Vec3 centre = f.pose * f.centre_mm;
    RigidMove move = as_move(by);
    // As far as somebody would type it.
    const auto rounded = [](const Vec3& v) {
      return Vec3(v.unaryExpr([](double x) { return std::round(1e4 * x) / 1e4 + 0.0; }));
    };
    move.rotation_deg = rounded(move.rotation_deg), move.about_mm = rounded(centre),
    move.translation_mm = rounded(by * centre - centre);
    const std::string p = "/head/fits/" + std::to_string(n++);
    r.set(p + "/stays", stays), r.set(p + "/moves", moves), r.set(p + "/length_mm", m.length_mm),
        r.set(p + "/residual_mm", m.residual_mm);
    r.set(p + "/line", to_json_line(Command(HeadCommand(MoveFragment{{moves, Vec3::Zero()}, move, 2}))));
    t.rows.push_back({name_of(head, stays) + " - " + name_of(head, moves), short_number(m.length_mm, 3),
                      short_number(m.residual_mm, 2), short_number(move.translation_mm.x(), 3),
                      short_number(move.translation_mm.y(), 3), short_number(move.translation_mm.z(), 3),
                      short_number(turned_deg(by), 3)});
  }
  for (const bone::Unmatched& u : found.refused)
    t.rows.push_back(
        {name_of(head, ids[size_t(u.a)]) + " - " + name_of(head, ids[size_t(u.b)]), u.reason, "-", "-", "-", "-", "-"});
  return t;
}

void fill_pictures(Result& r, const Head& head) {
  const auto picture = [&](const char* file, const char* words) {
    append(r, "/gallery", ResultPicture{std::string("head/") + file, words});
  };
  if (head.has_face()) {
    picture("before.png", "The face before");
    picture("after.png", "The face after");
    picture("profile-before.png", "In profile, before: soft-tissue landmarks");
    picture("profile-after.png", "In profile, after");
    picture("moved.png", "How far the face has moved, in mm");
  }
  picture("bones-before.png", "The bones before");
  picture("bones-after.png", "The bones after: cut surfaces in red");
  if (head.has_face()) {
    picture("wireframe.png", "The triangles of face and bone, after");
    picture("anaglyph.png", "Face and bones after, for red-cyan glasses");
    picture("through.png", "Bones through the face, after, with the landmarks on bone");
    if (!head.tissues().empty()) picture("tissue.png", "The net of the tissue between face and bone");
  }
}

}  // namespace

void fill_head(Result& r, const Head& head) {
  ResultTable t;
  t.title = "Fragments";
  t.about = "How far the middle of each fragment lies from where it was, and by how much it is turned.";
  t.columns = {"fragment", "volume, cm³", "right, mm", "forward, mm", "up, mm", "distance, mm", "turned, degrees"};
  int n = 0;
  for (const bone::Fragment& f : head.bones().fragments()) {
    const Vec3 way = f.pose * f.centre_mm - f.centre_mm;
    const std::string p = "/head/fragments/" + std::to_string(n++);
    r.set(p + "/id", f.id);
    r.set(p + "/name", f.name);
    r.set(p + "/fixed", f.fixed);
    r.set(p + "/volume_mm3", f.volume_mm3);
    for (int i = 0; i < 3; ++i) r.set(p + "/translation_mm/" + std::to_string(i), way[i]);
    r.set(p + "/rotation_deg", turned_deg(f.pose));
    t.rows.push_back({f.name + (f.fixed ? " (fixed)" : ""), short_number(f.volume_mm3 * 1e-3), short_number(way.x(), 3),
                      short_number(way.y(), 3), short_number(way.z(), 3), short_number(way.norm(), 3),
                      short_number(turned_deg(f.pose), 3)});
  }
  add_table(r, t);
  ResultTable g;
  g.title = "Gaps between fragments";
  g.about = "Between the cut surfaces of fragments that were cut from each other, or wherever two fragments overlap.";
  g.columns = {"fragments", "gap, mean, mm", "gap, largest, mm", "overlap, deepest, mm", "overlap, mm³"};
  r.set_empty_list("/head/gaps");
  n = 0;
  for (const bone::Gap& x : head.bones().gaps()) {
    const std::string p = "/head/gaps/" + std::to_string(n++);
    r.set(p + "/a", x.a), r.set(p + "/b", x.b);
    r.set(p + "/gap_mean_mm", x.gap_mean_mm), r.set(p + "/gap_max_mm", x.gap_max_mm);
    r.set(p + "/overlap_max_mm", x.overlap_max_mm), r.set(p + "/overlap_mm3", x.overlap_mm3);
    g.rows.push_back({name_of(head, x.a) + " - " + name_of(head, x.b), short_number(x.gap_mean_mm, 3),
                      short_number(x.gap_max_mm, 3), short_number(x.overlap_max_mm, 3),
                      short_number(x.overlap_mm3, 3)});
  }
  if (!g.rows.empty()) add_table(r, g);
  if (const ResultTable f = fits(r, head); !f.rows.empty()) add_table(r, f);
  ResultTable l;
  l.title = "Landmarks that moved";
  l.about = "By more than 0.05 mm. Names with a small letter lie on the face, the others on bone.";
  l.columns = {"landmark", "right, mm", "forward, mm", "up, mm", "distance, mm"};
  n = 0;
  for (const HeadLandmark& k : head.landmarks()) {
    const Vec3 way = head.landmark_mm(k) - k.X_mm;
    const std::string p = "/head/landmarks/" + std::to_string(n++);
    r.set(p + "/name", k.name);
    for (int i = 0; i < 3; ++i) r.set(p + "/moved_mm/" + std::to_string(i), way[i]);
    if (way.norm() > 0.05)
      l.rows.push_back({k.name, short_number(way.x(), 3), short_number(way.y(), 3), short_number(way.z(), 3),
                        short_number(way.norm(), 3)});
  }
  if (!l.rows.empty()) add_table(r, l);
  const std::vector<HeadMeasure> measures = head_measures(head.landmarks_at_rest(), head.landmarks_now());
  using Group = HeadMeasure::Group;
  ResultTable lengths = measure_table(
      r, measures, Group::cephalometry, "cephalometry", "Cephalometry",
      "Lengths in mm and angles in degrees between landmarks, in space. Names with a small letter lie on the face.");
  add_forehead(r, head, lengths);
  const ResultTable y =
      measure_table(r, measures, Group::asymmetry, "asymmetry", "Left and right",
                    "How far each landmark on the left is from mirroring its fellow on the right, in mm.");
  const ResultTable q =
      measure_table(r, measures, Group::picked, "picked", "Picked places",
                    "Lengths from each picked place to the next, and angles at the middle one of three.");
  for (const ResultTable& m : {lengths, y, q})
    if (!m.rows.empty()) add_table(r, m);
  if (head.has_face()) {
    const Moved m = face_moved(head);
    r.set("/head/face_moved_max_mm", m.most_mm);
    r.set("/head/face_moved_mean_mm", m.mean_mm);
    r.set("/metrics/face_moved_max_mm", m.most_mm);
  }
  double most = 0;
  for (const bone::Fragment& f : head.bones().fragments())
    most = std::max(most, (f.pose * f.centre_mm - f.centre_mm).norm());
  r.set("/metrics/fragments", uint64_t(head.bones().fragments().size()));
  r.set("/metrics/fragment_moved_max_mm", most);
  n = 0;
  ResultTable net;
  net.title = "Tissue between face and bone";
  net.about =
      "What hangs between the opposite regions. Springs alone hold no shape: how many motions they leave free is "
      "counted, and what holds these is said.";
  net.columns = {
      "tissue", "mode", "layers", "stiffness, kPa", "vertices", "of the face", "what its springs leave free"};
  for (const ConnectTissue& c : head.tissues()) {
    const std::string p = "/head/tissues/" + std::to_string(n);
    r.set(p + "/name", c.name), r.set(p + "/layers", c.layers), r.set(p + "/young_kPa", c.young_kPa),
        r.set(p + "/mode", kTissueKinds[size_t(c.mode)]);
    const simplex::Tissue& tissue = *head.face_model().tissues()[size_t(n)];
    const bool springs = c.mode == TissueKind::springs || c.mode == TissueKind::shape;
    const std::string free = springs ? head.face_model().free_motions(size_t(n)) : std::string();
    if (springs) r.set(p + "/free_motions", free);
    std::string mode = kTissueKinds[size_t(c.mode)];
    std::replace(mode.begin(), mode.end(), '_', ' ');
    net.rows.push_back({c.name, mode, std::to_string(c.layers), short_number(c.young_kPa, 3),
                        std::to_string(tissue.vertices()), std::to_string(tissue.link.size()), springs ? free : "-"});
    ++n;
  }
  if (!net.rows.empty()) add_table(r, net);
  n = 0;
  for (const std::string& w : head.face_model().warnings()) r.set("/head/warnings/" + std::to_string(n++), w);
  fill_pictures(r, head);
}

void print_head(const Head& head) {
  std::printf("bones       %zu fragments, %d vertices\n", head.bones().fragments().size(),
              head.bones().mesh().vertices());
  for (const bone::Fragment& f : head.bones().fragments()) {
    const Vec3 way = f.pose * f.centre_mm - f.centre_mm;
    if (way.norm() > 0 || f.pose.linear() != Mat3::Identity())
      std::printf("  moved     %d, %s: %.2f mm right, %.2f forward, %.2f up, turned by %.2f degrees\n", f.id,
                  f.name.c_str(), way.x(), way.y(), way.z(), turned_deg(f.pose));
  }
  if (!head.has_face()) return;
  for (const std::string& line : head.face_model().describe()) std::printf("tissue      %s\n", line.c_str());
  for (const std::string& line : head.face_model().warnings()) std::printf("  note      %s\n", line.c_str());
  const Moved m = face_moved(head);
  std::printf("face        moved by at most %.2f mm\n", m.most_mm);
}

void leave_head_figures(Result& r, const Head& head, const std::string& dir, const Snapshot& last, const Camera& camera,
                        Workers& workers) {
  write_whole_file(dir + "/measures.csv", to_csv(head_measures(head.landmarks_at_rest(), head.landmarks_now())));
  prepare_folder(dir + "/head");
  for (const std::string& why : report_skull(r, head, dir, last, camera, workers)) say(why);
}

}  // namespace limberg
