#include "app/assembly/lesson.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "app/assembly/lesson_steps_read.h"
#include "app/program/shipped.h"
#include "app/result/output.h"
#include "app/scene/toml_table.h"
#include "app/words/words.h"
#include "sim/base/elementary.h"
#include "sim/commands/authorship.h"
#include "sim/commands/kinds.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/strokes.h"
#include "sim/measure/cephalometry.h"
#include "sim/measure/plan.h"
#include "sim/measure/table.h"

namespace limberg {
namespace {

/// What a lesson may ask for: a figure of the session, or (measure not null) one of the table of measures.
struct Known {
  const char* name;
  const char* measure;
  const char* unit;
  double hi;
  enum Of { skin, bone, hand } of = skin;
};
constexpr Known kKnown[] = {{"corner_mm", nullptr, "mm", 100},
                            {"angle_deg", nullptr, "degrees", 180},
                            {"limb_percent", nullptr, "%", 100},
                            {"gap_mm", "suture_gap_max_mm", "mm", 50},
                            {"suture_N", "suture_force_max_N", "N", 100},
                            {"suture_peak_N", "suture_force_peak_N", "N", 100},
                            {"closure_N", "closure_force_N", "N", 1000},
                            {"dog_ear_mm", "dog_ear_mm", "mm", 100},
                            {"wound_gape_mm", "wound_gape_mm", "mm", 100},
                            {"step_off_mm", "step_off_mm", "mm", 50},
                            {"landmark_mm", "landmark_max_mm", "mm", 100},
                            {"waste_mm2", "waste_mm2", "mm2", 1e5},
                            {"pieces_wrong", nullptr, "", 100, Known::bone},
                            {"piece_mm", nullptr, "mm", 100, Known::bone},
                            {"piece_deg", nullptr, "degrees", 180, Known::bone},
                            {"sideways_mm", nullptr, "mm", 100, Known::bone},
                            {"forwards_mm", nullptr, "mm", 100, Known::bone},
                            {"upwards_mm", nullptr, "mm", 100, Known::bone},
                            {"stays_mm", nullptr, "mm", 100, Known::bone},
                            {"midline_mm", nullptr, "mm", 100, Known::bone},
                            {"osteotomy_gap_mm", nullptr, "mm", 100, Known::bone},
                            {"osteotomy_overlap_mm", nullptr, "mm", 100, Known::bone},
                            {"too_near_mm", nullptr, "mm", 100, Known::bone},
                            {"bone_outside_mm", nullptr, "mm", 100, Known::bone},
                            {"cephalometry_mm", nullptr, "mm", 100, Known::bone},
                            {"cephalometry_deg", nullptr, "degrees", 180, Known::bone},
                            {"time_s", nullptr, "s", 1e5, Known::hand},
                            {"path_mm", nullptr, "mm", 1e7, Known::hand},
                            {"movements", nullptr, "", 1e6, Known::hand},
                            {"undos", nullptr, "", 1e5, Known::hand}};
constexpr double kMissing_mm = 10;

double angle_deg(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 u = a - b, v = c - b;
  return std::abs(elementary::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v))) * 180 / std::numbers::pi;
}

struct Drawn {
  std::vector<ChartPoint> corners;
  bool closed = false;
};

std::string at_text(const ChartPoint& p) { return fmt::format("({:.1f}, {:.1f}) mm", p.x(), p.y()); }

/// Of the corner that is farthest from anything drawn, or that nothing was drawn for.
std::string why_missing(const DesignError& e) {
  const auto off = [](const MissingCorner& c) {
    return c.nearest ? (*c.nearest - c.planned).norm() : std::numeric_limits<double>::infinity();
  };
  const MissingCorner& c = *std::max_element(e.missing.begin(), e.missing.end(),
                                             [&](const auto& a, const auto& b) { return off(a) < off(b); });
  const std::string kind = c.outline ? "excision" : "incision";
  std::string t = fmt::format("{} of the plan's {} corners were looked for within {:g} mm and not found: that of an ",
                              e.missing.size(), e.corners, kMissing_mm);
  std::string s = t + kind + " at " + at_text(c.planned) + "; ";
  if (!c.nearest) return s + "no " + kind + " was drawn";
  t = fmt::format(" is {:.1f} mm away", off(c));
  return s + "the nearest drawn corner of one, at " + at_text(*c.nearest) + "," + t;
}

ChartPoint point_of(const toml::node& n, const std::string& file, const std::string& what) {
  const toml::array* a = n.as_array();
  const auto x = a && a->size() == 2 ? a->get(0)->value<double>() : std::nullopt,
             y = x ? a->get(1)->value<double>() : std::nullopt;
  if (!y || !std::isfinite(*x) || !std::isfinite(*y))
    throw InputError(file, int(n.source().begin.line), what + " is no place; expected [x, y] in mm");
  return {*x, *y};
}

std::vector<std::string> texts_of(const toml::table& root, const char* key, const std::string& file) {
  std::vector<std::string> out;
  const toml::node* n = root.get(key);
  if (!n) return out;
  const toml::array* a = n->as_array();
  if (!a || a->size() > 50)
    throw InputError(file, int(n->source().begin.line),
                     std::string(key) + " is no list of at most 50 texts; expected [\"...\", ...]");
  for (const toml::node& e : *a) {
    const auto text = e.value<std::string>();
    if (!text || text->empty() || text->size() > 2000)
      throw InputError(file, int(e.source().begin.line),
                       std::string(key) + " holds something that is no text; expected [\"...\", ...]");
    out.push_back(*text);
  }
  return out;
}

PlannedProcedure procedure_of(const toml::table& root, const std::string& file) {
  PlannedProcedure plan;
  Table p = section(root, "procedure", file);
  if (!p.has("name")) throw InputError(file, 0, "[procedure] names none; expected name = \"...\" of limberg procedure");
  p.text("name", plan.procedure);
  const Procedure* known = nullptr;
  try {
    known = &find_procedure(plan.procedure);
  } catch (const InputError& e) {
    p.fail("name", std::string("is ") + e.what());
  }
  p.real("turn_deg", plan.turn_deg, -360, 360);
  p.boolean("mirror", plan.mirrored);
  if (const toml::node* n = root.get("procedure")->as_table()->get("at_mm"))
    plan.at = point_of(*n, file, "procedure.at_mm");
  const toml::table* values = p.table("values");
  p.finish({"at_mm"});
  Table v(values, "procedure.values", file);
  for (const ProcedureParameter& q : known->parameters) {
    if (!v.has(q.name.c_str())) continue;
    double value = q.value;
    v.real(q.name.c_str(), value, q.lo, q.hi);
    plan.values.emplace_back(q.name, value);
  }
  if (values) {
    std::string list;
    for (const ProcedureParameter& q : known->parameters) list += (list.empty() ? "" : ", ") + q.name;
    for (const auto& [k, n] : *values)
      if (std::none_of(known->parameters.begin(), known->parameters.end(),
                       [&, key = std::string(k.str())](const auto& q) { return q.name == key; }))
        throw InputError(file, int(n.source().begin.line),
                         "unknown parameter \"" + std::string(k.str()).substr(0, 40) + "\" of " + known->name +
                             "; expected " + list);
  }
  return plan;
}

PlannedPiece piece_of(const toml::table& t, const std::string& file) {
  PlannedPiece piece;
  Table p(&t, "bone.piece", file);
  if (!p.has("name")) p.fail("name", "is missing; expected what the piece is called");
  p.text("name", piece.name, 60);
  piece.holds = texts_of(t, "holds", file), piece.apart_from = texts_of(t, "apart_from", file);
  piece.about = texts_of(t, "about", file);
  if (piece.holds.empty()) p.fail("holds", "names no landmark; expected those that lie on the piece");
  for (const auto& [key, to, most] : {std::tuple("move_mm", &piece.move.translation_mm, 500.),
                                      std::tuple("turn_deg", &piece.move.rotation_deg, 360.)}) {
    std::vector<double> x;
    p.numbers(key, x, -most, most, false, 3);
    if (!x.empty() && x.size() != 3) p.fail(key, "has not three numbers; expected [x, y, z]");
    if (!x.empty()) *to = Vec3(x[0], x[1], x[2]);
  }
  p.finish({"holds", "apart_from", "about"});
  return piece;
}

BonePlan bones_of(const toml::table& root, const std::string& file) {
  BonePlan plan;
  Table b = section(root, "bone", file);
  b.integer("fragments", 1, 1000, [&](int64_t n) { plan.fragments = int(n); });
  const toml::table& t = *root.get("bone")->as_table();
  plan.stays = texts_of(t, "stays", file);
  if (const toml::node* n = t.get("piece")) {
    const toml::array* a = n->as_array();
    if (!a) throw InputError(file, int(n->source().begin.line), "bone.piece is no list; expected [[bone.piece]]");
    for (const toml::node& e : *a) {
      if (!e.is_table())
        throw InputError(file, int(e.source().begin.line), "bone.piece is no table; expected [[bone.piece]]");
      plan.pieces.push_back(piece_of(*e.as_table(), file));
    }
  }
  if (plan.pieces.empty()) throw InputError(file, 0, "[bone] has no piece; expected at least one [[bone.piece]]");
  if (const toml::table* c = b.table("cephalometry")) {
    Table figures(c, "bone.cephalometry", file);
    for (const CephalometricMeasure& m : cephalometric_measures()) {
      if (!figures.has(m.name.c_str())) continue;
      double wanted = 0;
      figures.real(m.name.c_str(), wanted, -360, 1000);
      plan.cephalometry.emplace_back(m.name, wanted);
    }
    for (const auto& [k, n] : *c)
      if (std::none_of(plan.cephalometry.begin(), plan.cephalometry.end(),
                       [&, key = std::string(k.str())](const auto& x) { return x.first == key; }))
        throw InputError(
            file, int(n.source().begin.line),
            "unknown figure \"" + std::string(k.str()).substr(0, 40) + "\"; expected one of cephalometry, as overjet");
  }
  b.finish({"stays", "piece"});
  return plan;
}

}  // namespace

bool looks_like_lesson(std::string_view text) {
  return text.starts_with("lesson") || text.find("\nlesson") != std::string_view::npos;
}

Lesson parse_lesson(const std::string& text, const std::string& file) {
  const toml::table root = parse_toml(text, file, "a lesson");
  Lesson l;
  l.file = file;
  Table top(&root, "", file);
  for (const char* key : {"lesson", "goal", "scene"})
    if (!top.has(key)) top.fail(key, std::string("is missing; expected ") + key + " = \"...\"");
  top.text("lesson", l.title, 200);
  top.text("goal", l.goal, 4000);
  top.text("scene", l.scene);
  top.boolean("by_script", l.by_script);
  l.steps = texts_of(root, "steps", file), l.hints = texts_of(root, "hints", file);
  top.finish({"steps", "hints", "procedure", "bone", "tolerance", "landmarks", "step", "limit"});
  if (!root.contains("procedure") && !root.contains("bone") && !l.by_script)
    throw InputError(file, 0,
                     "has neither [procedure] nor [bone], nor by_script = true; expected what the lesson is about");
  if (root.contains("procedure") && l.by_script)
    top.fail("by_script",
             "stands beside [procedure]; expected one of them: a figure of the repertoire or a script alone");
  if (root.contains("procedure")) l.plan = procedure_of(root, file);
  if (root.contains("bone")) l.bone = bones_of(root, file);
  l.words = read_lesson_words(root, file);

  Table t = section(root, "tolerance", file);
  for (const Known& k : kKnown) {
    if (!t.has(k.name)) {
      double none = 0;
      t.real(k.name, none, 0, k.hi);
      continue;
    }
    if (k.of == Known::bone && !l.bone) t.fail(k.name, "is asked of bones, and there is no [bone]; expected one");
    if (k.of == Known::skin && !l.plan && !(l.by_script && k.measure))
      t.fail(k.name, "is asked of skin, and there is no [procedure]; expected one");
    double limit = 0;
    t.real(k.name, limit, 0, k.hi);
    l.tolerances.emplace_back(k.name, limit);
  }
  t.finish();
  // Whatever else a lesson on bones asks is of no use where the wrong piece was cut.
  if (l.bone &&
      std::none_of(l.tolerances.begin(), l.tolerances.end(), [](const auto& x) { return x.first == "pieces_wrong"; }))
    l.tolerances.insert(l.tolerances.begin(), {"pieces_wrong", 0});
  if (l.tolerances.empty()) throw InputError(file, 0, "[tolerance] holds nothing; expected at least one limit");
  if (const toml::node* n = root.get("landmarks")) {
    if (!n->is_table())
      throw InputError(file, int(n->source().begin.line), "landmarks is not a table; expected [landmarks]");
    for (const auto& [k, e] : *n->as_table())
      l.landmarks.push_back(
          {std::string(k.str()), point_of(e, file, "landmarks." + std::string(k.str()).substr(0, 40))});
  }
  return l;
}

std::string find_lesson(const std::string& name_or_path) {
  namespace fs = std::filesystem;
  std::error_code ec;
  if (fs::exists(name_or_path, ec) && !fs::is_directory(name_or_path, ec))
    return name_or_path;  // an --out folder may have the name
  std::string list;
  for (const std::string& root : shipped_roots()) {
    const std::string folder = root == "." ? "app/lessons" : root + "/app/lessons";
    const fs::path candidate = fs::path(folder) / (name_or_path + ".toml");
    if (name_or_path.find('/') == std::string::npos && fs::exists(candidate, ec)) return candidate.string();
    std::vector<std::string> names;
    for (fs::directory_iterator it(folder, ec), end; !ec && it != end; it.increment(ec))
      if (it->path().extension() == ".toml") names.push_back(it->path().stem().string());
    std::sort(names.begin(), names.end());
    if (!names.empty()) list.clear();
    for (const std::string& n : names) list += (list.empty() ? "" : ", ") + n;
  }
  throw InputError(name_or_path, 0,
                   "no such lesson; expected a lesson file" + (list.empty() ? "" : " or one of: " + list));
}

std::string made_for_another(const Lesson& l, const std::string& scene_name, const std::string& scene_path) {
  const auto stem = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
  if (l.scene.empty() || l.scene == scene_name || stem(l.scene) == scene_name || stem(l.scene) == stem(scene_path))
    return {};
  return "the lesson \"" + l.title + "\" is for the scene " + l.scene + ", not for " + scene_name +
         "; it is judged by it all the same";
}

Lesson open_lesson(const std::string& name_or_path) {
  const std::string file = find_lesson(name_or_path);
  return parse_lesson(read_whole_file(file, 1 << 20), file);
}

std::optional<DesignError> design_error(const PlanOnSkin& plan, std::span<const Command> script) {
  std::vector<Drawn> drawn;
  for (const StandingAct& act : standing_acts(script)) {
    if (act.shown) continue;
    const Command& c = act.command;
    if (const auto* e = std::get_if<Excise>(&c)) drawn.push_back({corners_of_outline(e->outline), true});
    if (const auto* i = std::get_if<Incise>(&c)) drawn.push_back({corners_of_path(i->path), false});
  }
  if (drawn.empty()) return std::nullopt;
  DesignError out;
  double sum = 0;
  int found = 0;
  const auto compare = [&](const std::vector<Vec2>& figure, bool closed) {
    std::vector<ChartPoint> on_chart;
    for (const Vec2& p : figure) on_chart.push_back(plan.chart(p));
    const std::vector<ChartPoint> want = closed ? corners_of_outline(on_chart) : corners_of_path(on_chart);
    // Every planned corner and the drawn corner of the same kind of cut nearest to it: which cut, which corner.
    std::vector<std::pair<const Drawn*, size_t>> match(want.size(), {nullptr, 0});
    for (size_t i = 0; i < want.size(); ++i) {
      double best = std::numeric_limits<double>::infinity();
      for (const Drawn& d : drawn) {
        if (d.closed != closed) continue;
        for (size_t k = 0; k < d.corners.size(); ++k)
          if (const double r = (d.corners[k] - want[i]).norm(); r < best) best = r, match[i] = {&d, k};
      }
      ++out.corners;
      if (!(best < kMissing_mm)) {
        out.missing.push_back(
            {closed, want[i], match[i].first ? std::optional(match[i].first->corners[match[i].second]) : std::nullopt});
        match[i].first = nullptr;
        continue;
      }
      sum += best, ++found;
      out.corner_max_mm = std::max(out.corner_max_mm, best);
    }
    const size_t n = want.size();
    for (size_t i = 0; i < n; ++i) {
      const auto [d, k] = match[i];
      if (!d) continue;
      const size_t m = d->corners.size();
      if ((closed && n >= 3 && m >= 3) || (!closed && i > 0 && i + 1 < n && k > 0 && k + 1 < m))
        out.angle_max_deg =
            std::max(out.angle_max_deg,
                     std::abs(angle_deg(want[(i + n - 1) % n], want[i], want[(i + 1) % n]) -
                              angle_deg(d->corners[(k + m - 1) % m], d->corners[k], d->corners[(k + 1) % m])));
      const size_t j = i + 1 == n ? 0 : i + 1;
      if ((j == 0 && !closed) || !match[j].first) continue;
      const double length = (want[j] - want[i]).norm();
      if (length > 0)
        out.limb_max_percent = std::max(
            out.limb_max_percent,
            100 * std::abs((match[j].first->corners[match[j].second] - d->corners[k]).norm() - length) / length);
    }
  };
  for (const auto& e : plan.figure.excisions) compare(e, true);
  for (const auto& i : plan.figure.incisions) compare(i, false);
  if (found > 0) out.corner_mean_mm = sum / found;
  return out;
}

std::vector<Judgement> judge(const Lesson& lesson, const LessonValues& values) {
  std::vector<Judgement> out;
  for (const auto& [name, limit] : lesson.tolerances) {
    Judgement j;
    j.name = name, j.limit = limit;
    for (const Known& k : kKnown)
      if (name == k.name) j.unit = k.unit;
    if (const auto at = values.value.find(name); at == values.value.end()) {
      const auto why = values.why_not.find(name);
      j.why = why == values.why_not.end() ? "there is no such figure of this session" : why->second;
    } else if (!std::isfinite(at->second)) {
      j.why = "what was measured is no number";
    } else {
      j.value = at->second, j.met = at->second <= limit;
      if (const auto where = values.place.find(name); where != values.place.end()) j.why = where->second;
    }
    out.push_back(std::move(j));
  }
  return out;
}

void withhold_shown(std::vector<Judgement>& judged, std::span<const Command> script) {
  int cuts = 0, cuts_shown = 0, all = 0, all_shown = 0;
  for (const StandingAct& a : standing_acts(script)) {
    const bool cut = cuts_skin(a.command) && !std::holds_alternative<Undermine>(a.command);
    cuts += cut, cuts_shown += cut && a.shown;
    ++all, all_shown += a.shown;
  }
  const bool any = was_shown(script);
  for (Judgement& j : judged) {
    const Known* k =
        std::find_if(std::begin(kKnown), std::end(kKnown), [&](const Known& x) { return j.name == x.name; });
    if (k == std::end(kKnown) || j.name == "undos") continue;
    const bool of_cuts =
        j.name == "corner_mm" || j.name == "angle_deg" || j.name == "limb_percent" || j.name == "waste_mm2";
    if (k->of == Known::hand ? !any : of_cuts ? cuts_shown == 0 : all_shown == 0) continue;
    j.value.reset(), j.met = false;
    j.why = k->of == Known::hand ? std::string(english("the program has shown a part, which is not the learner's"))
            : of_cuts            ? fmt::format(english("{} of {} cuts were shown by the program"), cuts_shown, cuts)
                                 : fmt::format(english("{} of {} acts were shown by the program"), all_shown, all);
  }
}

namespace {

/// What a learner can do about a tolerance that was missed.
constexpr std::array<std::array<const char*, 3>, 30> kAdvice{
    {{"corner_mm", english("Corners of the cuts"),
      english("mark the corners before you cut, and draw from one to the next")},
     {"angle_deg", english("Angles of the cuts"),
      english("turn at each corner as the plan does; rest there before you go on")},
     {"limb_percent", english("Lengths of the limbs"), english("measure the limbs: each as long as the plan has it")},
     {"gap_mm", english("Bites of a stitch apart"), english("bring the edges together with a hook before you tie")},
     {"suture_N", english("Pull of a stitch"), english("undermine further, or close where the pull is least first")},
     {"suture_peak_N", english("Strongest pull of a stitch"),
      english("tie the stitch that carries the tension last of its row, or undermine further")},
     {"closure_N", english("Pull of the closure"),
      english("lay the closure along the skin that gives: across the tension lines less is needed")},
     {"dog_ear_mm", english("Dog-ear"),
      english("take the cone out as a small triangle, or make the ends of the wound sharper")},
     {"wound_gape_mm", english("Gape of the wound"),
      english("set the stitches closer together, and into the corners first")},
     {"step_off_mm", english("Step between the edges"), english("take both bites at one depth")},
     {"landmark_mm", english("Landmark drawn away"), english("turn the closure so that it pulls past what must stay")},
     {"waste_mm2", english("Skin excised"), english("excise no more than the plan does")},
     {"pieces_wrong", english("Pieces of bone"),
      english("carry the cut through all of the bone, and round the landmarks that belong to the piece")},
     {"piece_mm", english("Place of the piece"),
      english("carry the piece as far as the plan does, and look at its landmarks")},
     {"piece_deg", english("Turn of the piece"), english("keep the piece level while you carry it")},
     {"sideways_mm", english("Piece to the side"), english("look from the front: the piece went to the side")},
     {"forwards_mm", english("Piece forwards"), english("look from the side: too far forwards, or not far enough")},
     {"upwards_mm", english("Piece upwards"), english("look from the side: the piece went up or down")},
     {"stays_mm", english("What should stay"), english("leave alone what should stay: saw it free before you pull")},
     {"midline_mm", english("Midline"), english("look from above: bring the piece back to the midline")},
     {"osteotomy_gap_mm", english("Gap of the bone cut"), english("let the piece slide along its cut")},
     {"osteotomy_overlap_mm", english("Bone in bone"),
      english("take away what stands in the piece's way, or carry it less far")},
     {"too_near_mm", english("Cut too near to what must be spared"),
      english("saw farther away from the red line: roots and nerve lie there")},
     {"bone_outside_mm", english("Bone outside the skin"), english("bone stands out of the skin: carry it less far")},
     {"cephalometry_mm", english("Cephalometry"), english("measure the bite before you plate it")},
     {"cephalometry_deg", english("Angles of cephalometry"),
      english("turn the piece about its hinge, and measure again")},
     {"time_s", english("Time"), english("plan the order first; hesitation cost more than the hands")},
     {"path_mm", english("Way of the hand"),
      english("shorter ways: choose the next tool near the place of the next act")},
     {"movements", english("Movements"), english("fewer and longer movements")},
     {"undos", english("Acts taken back"), english("look twice before you press: each act taken back was a cut")}}};

const std::array<const char*, 3>* advice_on(const std::string& tolerance) {
  const auto* a = std::find_if(kAdvice.begin(), kAdvice.end(), [&](const auto& x) { return tolerance == x[0]; });
  return a == kAdvice.end() ? nullptr : a;
}

}  // namespace

std::string words_of_tolerance(const std::string& name) {
  const auto* known = advice_on(name);
  return known ? (*known)[1] : name;
}

std::vector<std::string> to_do_better(std::span<const Judgement> judged, size_t most) {
  std::vector<std::pair<double, std::string>> all;
  for (const Judgement& j : judged) {
    if (j.met || j.name.empty()) continue;
    const auto* advice = advice_on(j.name);
    const std::string what = advice ? (*advice)[2] : english("look at it again");
    if (j.value)
      all.emplace_back(*j.value / std::max(j.limit, 0.1),
                       fmt::format(english("{}: {} where {} is the most: {}."), words_of_tolerance(j.name),
                                   fmt::format("{:.3g}", *j.value) + (j.unit.empty() ? "" : " " + j.unit),
                                   fmt::format("{:.3g}", j.limit), what));
    else
      all.emplace_back(j.why.find("shown by the program") != std::string::npos ? 0.5 : 1e6,
                       fmt::format("{}: {}.", words_of_tolerance(j.name), j.why));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<std::string> out;
  for (size_t i = 0; i < all.size() && i < most; ++i) out.push_back(std::move(all[i].second));
  return out;
}

LessonValues lesson_values(const Metrics& m, const std::optional<DesignError>& e) {
  LessonValues v;
  for (const Known& k : kKnown)
    if (k.measure)
      if (const std::optional<double> of = find_measure(k.measure)->value(m)) v.value[k.name] = *of;
  const auto without = [&](std::initializer_list<const char*> names, const std::string& why) {
    for (const char* name : names) v.value.erase(name), v.why_not[name] = why;
  };
  if (m.sutures.empty())
    without({"gap_mm", "suture_N", "suture_peak_N", "closure_N"},
            english("stitches were looked for at the end; there is none"));
  if (!(m.gape.rim_length_mm > 0)) without({"wound_gape_mm"}, english("a wound was looked for; nothing was cut"));
  if (!m.waste_mm2) without({"waste_mm2"}, english("an excision was looked for; nothing was excised"));
  const auto gone =
      std::find_if(m.landmarks.begin(), m.landmarks.end(), [](const NamedLandmark& l) { return !l.figure; });
  if (m.landmarks.empty())
    without({"landmark_mm"}, english("landmarks were looked for; neither scene nor lesson names one"));
  else if (gone != m.landmarks.end())
    without({"landmark_mm"},
            "the skin of " + gone->name + " was looked for at " + at_text(gone->at) + "; there is none");
  if (!e)
    without({"corner_mm", "angle_deg", "limb_percent"},
            english("cuts were looked for where the plan has them; nothing was excised or incised"));
  else if (!e->missing.empty())
    without({"corner_mm", "angle_deg", "limb_percent"}, why_missing(*e));
  else
    v.value.insert(
        {{"corner_mm", e->corner_max_mm}, {"angle_deg", e->angle_max_deg}, {"limb_percent", e->limb_max_percent}});
  without({"time_s"}, english("the session's time was looked for; there is none"));
  without({"path_mm", "movements"}, english("a hand's movements were looked for; none are recorded"));
  return v;
}

LessonValues values_of_metrics(const std::map<std::string, double>& metrics) {
  LessonValues v;
  for (const Known& k : kKnown)
    if (k.measure)
      if (const auto at = metrics.find(k.measure); at != metrics.end()) v.value[k.name] = at->second;
  return v;
}

}  // namespace limberg
