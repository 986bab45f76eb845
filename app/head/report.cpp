#include "app/head/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

#include "app/head/head_result.h"
#include "app/head/measures.h"
#include "app/head/skull_comparison.h"
#include "app/head/soft_ratios.h"
#include "app/result/metrics.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/tables.h"
#include "app/words/words.h"
#include "sim/commands/script.h"
#include "sim/measure/bone_outside.h"
#include "sim/skull/bone/sorting.h"

namespace limberg {

namespace {

double turned_deg(const Eigen::Isometry3d& pose) {
  return Eigen::AngleAxisd(pose.linear()).angle() * 180 / std::numbers::pi;
}

struct Moved {
  double most_mm = 0, mean_mm = 0;  // mean: of the places that moved by more than 0.1 mm
  double stretch_p99 = 1;           // 99 % of the edges at these places are drawn out by less
  int64_t places = 0;
};

Moved face_moved(const Head& head) {
  Moved m;
  const simplex::Mesh& face = head.face();
  const std::vector<Vec3>& X = head.face_model().rest_mm();
  std::vector<double> stretch;
  for (int32_t v = 0; v < face.slots(); ++v) {
    if (!face.alive(v)) continue;
    const double d = (face.x_mm[size_t(v)] - X[size_t(v)]).norm();
    m.most_mm = std::max(m.most_mm, d);
    if (d <= 0.1) continue;
    m.mean_mm += d, ++m.places;
    for (const int32_t w : face.nbr[size_t(v)]) {
      if (w < 0) continue;
      const double rest_mm = (X[size_t(w)] - X[size_t(v)]).norm();
      if (rest_mm > 0) stretch.push_back((face.x_mm[size_t(w)] - face.x_mm[size_t(v)]).norm() / rest_mm);
    }
  }
  if (m.places > 0) m.mean_mm /= double(m.places);
  if (!stretch.empty()) {
    const auto at = stretch.begin() + long(0.99 * double(stretch.size() - 1));
    std::nth_element(stretch.begin(), at, stretch.end());
    m.stretch_p99 = *at;
  }
  return m;
}

std::string name_of(const Head& head, int32_t id) {
  const bone::Fragment* f = head.bones().fragment(id);
  return f ? f->name : std::to_string(id);
}

std::string tenth(double v) { return fmt::format("{:.1f}", v); }
std::string change(double v) { return fmt::format("{:+.2f}", std::round(100 * v) / 100 + 0.0); }

/// What head_measures finds, as rows of the report; one group in each table.
ResultTable measure_table(std::vector<ResultMeasure>& out, const std::vector<HeadMeasure>& all,
                          HeadMeasure::Group group, const char* title, const char* about) {
  ResultTable t;
  t.title = title, t.about = about;
  t.columns = {english("figure"), english("before"), english("after"),
               english("change"), english("unit"),   english("norm")};
  for (const HeadMeasure& m : all) {
    if (m.group != group) continue;
    out.push_back({m.name, m.unit, m.before, m.now});
    t.rows.push_back({m.name, tenth(m.before), tenth(m.now), change(m.change()), m.unit, m.norm});
  }
  return t;
}

/// The middle of the forehead from the sella, where a scene names it.
void add_forehead(std::vector<ResultMeasure>& out, const Head& head, ResultTable& t) {
  const auto at = [](const NamedPlaces& l, const std::string& name) -> std::optional<Vec3> {
    for (const auto& [k, x] : l)
      if (k == name) return x;
    return std::nullopt;
  };
  const NamedPlaces was = head.landmarks_at_rest(), is = head.landmarks_now();
  for (const auto& [name, words] :
       {std::pair("F", english("S-F, frontal bone")), std::pair("f'", english("S-f', forehead"))})
    if (at(was, "S") && at(was, name)) {
      const double a = (*at(was, "S") - *at(was, name)).norm(), b = (*at(is, "S") - *at(is, name)).norm();
      out.push_back({words, "mm", a, b});
      t.rows.push_back({words, tenth(a), tenth(b), change(b - a), "mm", ""});
    }
}

/// Which fragments fit each other by their cut rings, and for each pair the line of a script that puts it together.
ResultTable fits(std::vector<ResultFit>& out, const Head& head) {
  ResultTable t;
  t.title = english("Fragments that fit each other");
  t.about = english(
      "Found by their cut rings, wherever they lie, and verified; how to move the second "
      "one so "
      "that it fits the first where that is now (one of them at a time: \"sort\" in a script puts all of them "
      "together). Those that would have fitted are named with the reason.");
  t.columns = {english("fragments"),      english("rings together, mm"), english("residual, mm"),
               english("right, mm"),      english("forward, mm"),        english("up, mm"),
               english("turned, degrees")};
  if (head.bones().fragments().size() < 2) return t;
  std::vector<int32_t> ids;
  const bone::Sorting found = bone::sort_fragments(bone::pieces_of(head.bones(), &ids));
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
    out.push_back({stays, moves, m.length_mm, m.residual_mm,
                   to_json_line(Command(HeadCommand(MoveFragment{{moves, Vec3::Zero()}, move, 2})))});
    t.rows.push_back({name_of(head, stays) + " - " + name_of(head, moves), short_number(m.length_mm, 3),
                      short_number(std::round(1e4 * m.residual_mm) / 1e4, 2), short_number(move.translation_mm.x(), 3),
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
    picture("before.png", english("The face before"));
    picture("after.png", english("The face after"));
    picture("profile-before.png", english("In profile, before: soft-tissue landmarks"));
    picture("profile-after.png", english("In profile, after"));
    picture("moved.png", english("How far the face has moved, in mm"));
  }
  picture("bones-before.png", english("The bones before"));
  picture("bones-after.png", english("The bones after: cut surfaces in red"));
  if (head.has_face()) {
    picture("wireframe.png", english("The triangles of face and bone, after"));
    picture("anaglyph.png", english("Face and bones after, for red-cyan glasses"));
    picture("through.png", english("Bones through the face, after, with the landmarks on bone"));
    if (!head.tissues().empty()) picture("tissue.png", english("The net of the tissue between face and bone"));
  }
}

ResultTable fragments(ResultHead& out, ResultBones& bones, const Head& head) {
  ResultTable t;
  t.title = english("Fragments");
  t.about = english("How far the middle of each fragment lies from where it was, and by how much it is turned.");
  t.columns = {english("fragment"), english("volume, cm³"),  english("right, mm"),      english("forward, mm"),
               english("up, mm"),   english("distance, mm"), english("turned, degrees")};
  std::vector<ResultFragment> list;
  double most = 0;
  for (const bone::Fragment& f : head.bones().fragments()) {
    const Vec3 way = f.pose * f.centre_mm - f.centre_mm;
    most = std::max(most, way.norm());
    list.push_back({f.id, f.name, f.fixed, f.volume_mm3, vector_of(way), turned_deg(f.pose)});
    t.rows.push_back({f.name + (f.fixed ? " (fixed)" : ""), short_number(f.volume_mm3 * 1e-3), short_number(way.x(), 3),
                      short_number(way.y(), 3), short_number(way.z(), 3), short_number(way.norm(), 3),
                      short_number(turned_deg(f.pose), 3)});
  }
  bones.fragments = list.size(), bones.fragment_moved_max_mm = most;
  out.fragments = unless_empty(std::move(list));
  return t;
}

ResultTable gaps(ResultHead& out, const Head& head) {
  ResultTable t;
  t.title = english("Gaps between fragments");
  t.about = english(
      "Between the cut surfaces of fragments that were cut from each other, or wherever two fragments overlap.");
  t.columns = {english("fragments"), english("gap, mean, mm"), english("gap, largest, mm"),
               english("overlap, deepest, mm"), english("overlap, mm³")};
  for (const bone::Gap& x : head.bones().gaps()) {
    out.gaps.push_back({x.a, x.b, x.gap_mean_mm, x.gap_max_mm, x.overlap_max_mm, x.overlap_mm3});
    t.rows.push_back({name_of(head, x.a) + " - " + name_of(head, x.b), short_number(x.gap_mean_mm, 3),
                      short_number(x.gap_max_mm, 3), short_number(x.overlap_max_mm, 3),
                      short_number(x.overlap_mm3, 3)});
  }
  return t;
}

ResultTable landmarks(ResultHead& out, const Head& head) {
  ResultTable t;
  t.title = english("Landmarks that moved");
  t.about = english("By more than 0.05 mm. Names with a small letter lie on the face, the others on bone.");
  t.columns = {english("landmark"), english("right, mm"), english("forward, mm"), english("up, mm"),
               english("distance, mm")};
  std::vector<ResultHeadLandmark> list;
  for (const HeadLandmark& k : head.landmarks()) {
    const Vec3 way = head.landmark_mm(k) - k.X_mm;
    list.push_back({k.name, vector_of(way)});
    if (way.norm() > 0.05)
      t.rows.push_back({k.name, short_number(way.x(), 3), short_number(way.y(), 3), short_number(way.z(), 3),
                        short_number(way.norm(), 3)});
  }
  out.landmarks = unless_empty(std::move(list));
  return t;
}

void measures(ResultHead& out, std::vector<ResultTable>& tables, const Head& head) {
  const std::vector<HeadMeasure> all = head_measures(head.landmarks_at_rest(), head.landmarks_now());
  using Group = HeadMeasure::Group;
  std::vector<ResultMeasure> cephalometry, asymmetry, picked;
  tables.push_back(measure_table(cephalometry, all, Group::cephalometry, "Cephalometry",
                                 english("Lengths in mm and angles in degrees between landmarks, in space. Names with "
                                         "a small letter lie on the face.")));
  add_forehead(cephalometry, head, tables.back());
  tables.push_back(
      measure_table(asymmetry, all, Group::asymmetry, english("Left and right"),
                    english("How far each landmark on the left is from mirroring its fellow on the right, in mm.")));
  tables.push_back(
      measure_table(picked, all, Group::picked, english("Picked places"),
                    english("Lengths from each picked place to the next, and angles at the middle one of three.")));
  out.cephalometry = unless_empty(std::move(cephalometry));
  out.asymmetry = unless_empty(std::move(asymmetry));
  out.picked = unless_empty(std::move(picked));
}

ResultTable soft_to_hard(ResultHead& out, const Head& head) {
  ResultTable t;
  t.title = english("Skin after bone");
  t.about = english(
      "How far a landmark on the skin has gone along the move of the one on bone beneath it, over that move; beside it "
      "what papers found in patients months later.");
  t.columns = {english("skin"),  english("bone"),        english("bone, mm"), english("skin, mm"),
               english("ratio"), english("in patients"), english("source")};
  std::vector<ResultSoftRatio> list;
  for (const SoftRatio& r : soft_ratios(head.landmarks_at_rest(), head.landmarks_now())) {
    ResultSoftRatio x{r.soft, r.bone, r.bone_mm, r.soft_mm, r.ratio, {}, {}, {}};
    if (r.known_high > 0) x.known_low = r.known_low, x.known_high = r.known_high, x.source = r.source;
    t.rows.push_back({r.soft, r.bone, tenth(r.bone_mm), tenth(r.soft_mm), fmt::format("{:.2f}", r.ratio),
                      r.known_high > 0 ? fmt::format("{:.2f} to {:.2f}", r.known_low, r.known_high) : "-",
                      r.known_high > 0 ? r.source : "-"});
    list.push_back(std::move(x));
  }
  out.soft_to_hard = unless_empty(std::move(list));
  return t;
}

/// Bone that the operation has brought out of the skin.
ResultTable pierced(ResultHead& out, const Head& head) {
  ResultTable t;
  Snapshot now;
  head.fill(now);
  const BoneOutside o = bone_outside(now);
  out.bone_outside = std::vector<ResultBoneOutside>{{o.depth_mm, o.area_mm2, vector_of(o.at_mm), o.object}};
  if (!(o.depth_mm > 0)) return t;
  t.title = english("Bone outside the skin");
  t.about =
      english("Where bone that lay under the skin before stands out of it now: the place that stands out farthest.");
  t.columns = {english("fragment"), english("right, mm"),  english("forward, mm"),
               english("up, mm"),   english("out by, mm"), english("area, mm²")};
  t.rows.push_back({name_of(head, o.object), tenth(o.at_mm.x()), tenth(o.at_mm.y()), tenth(o.at_mm.z()),
                    tenth(o.depth_mm), short_number(o.area_mm2, 3)});
  return t;
}

ResultTable tissues(ResultHead& out, const Head& head) {
  ResultTable t;
  t.title = english("Tissue between face and bone");
  t.about = english(
      "What hangs between the opposite regions. Springs alone hold no shape: how many motions they leave free is "
      "counted, and what holds these is said.");
  t.columns = {english("tissue"),
               english("mode"),
               english("layers"),
               english("stiffness, kPa"),
               english("vertices"),
               english("of the face"),
               english("what its springs leave free")};
  std::vector<ResultTissue> list;
  for (const ConnectTissue& c : head.tissues()) {
    const size_t n = list.size();
    const simplex::Tissue& tissue = *head.face_model().tissues()[n];
    const bool springs = c.mode == TissueKind::springs || c.mode == TissueKind::shape;
    const MaybeText free = springs ? MaybeText(head.face_model().free_motions(n)) : MaybeText();
    std::string mode = kTissueKinds[size_t(c.mode)];
    list.push_back({c.name, c.layers, c.young_kPa, mode, free});
    std::replace(mode.begin(), mode.end(), '_', ' ');
    t.rows.push_back({c.name, mode, std::to_string(c.layers), short_number(c.young_kPa, 3),
                      std::to_string(tissue.vertices()), std::to_string(tissue.link.size()), free.value_or("-")});
  }
  out.tissues = unless_empty(std::move(list));
  return t;
}

}  // namespace

void fill_head(Result& r, const Head& head) {
  ResultHead out;
  ResultBones bones;
  std::vector<ResultTable> tables{fragments(out, bones, head), gaps(out, head)};
  std::vector<ResultFit> fit;
  tables.push_back(fits(fit, head));
  out.fits = unless_empty(std::move(fit));
  tables.push_back(landmarks(out, head));
  measures(out, tables, head);
  if (head.has_face()) {
    const Moved m = face_moved(head);
    out.face_moved_max_mm = bones.face_moved_max_mm = m.most_mm;
    out.face_moved_mean_mm = m.mean_mm, out.face_stretch_p99 = m.stretch_p99;
    tables.push_back(soft_to_hard(out, head));
    tables.push_back(pierced(out, head));
  }
  tables.push_back(tissues(out, head));
  out.warnings = unless_empty(head.face_model().warnings());
  write_fields(r, "/head", out);
  for (const ResultTable& t : tables)
    if (!t.rows.empty()) add_table(r, t);
  write_fields(r, "/metrics", bones);
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
  std::printf("face        moved by at most %.2f mm, drawn out to %.2f of its length (99 %% of what moved)\n",
              m.most_mm, m.stretch_p99);
}

void leave_head_figures(Result& r, const Head& head, const std::vector<std::string>& normal_files,
                        const std::string& dir, const Snapshot& last, const Camera& camera, Workers& workers) {
  write_whole_file(dir + "/measures.csv", to_csv(head_measures(head.landmarks_at_rest(), head.landmarks_now())));
  prepare_folder(dir + "/head");
  for (const std::string& why : report_skull(r, head, normal_files, dir, last, camera, workers)) say(why);
}

}  // namespace limberg
