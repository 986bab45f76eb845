#include "app/teaching/against_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "app/teaching/saw_watch.h"
#include "sim/base/elementary.h"
#include "sim/commands/table.h"
#include "sim/geometry/polyline.h"
#include "sim/measure/plan.h"

namespace limberg {
namespace {

constexpr double kDepth_mm = 1, kBlade_deg = 15, kHook_mm = 4, kCarried_mm = 8, kBite_mm = 2.5, kPocket_mm = 6,
                 kPiece_mm = 2, kTurn_deg = 4, kSaw_mm = 4;  // how far off an act may be
constexpr double kSample_mm = 1, kNear_mm = 10;

std::vector<ChartPoint> sampled(const std::vector<ChartPoint>& path, bool closed) {
  std::vector<ChartPoint> out;
  const size_t n = path.size(), edges = closed ? n : n - 1;
  for (size_t i = 0; i < edges && n > 1; ++i) {
    const ChartPoint &a = path[i], &b = path[(i + 1) % n];
    const int pieces = std::max(1, int(std::ceil((b - a).norm() / kSample_mm)));
    for (int k = 0; k < pieces; ++k) out.push_back(a + (b - a) * (double(k) / pieces));
  }
  if (!closed && n > 0) out.push_back(path.back());
  return out;
}

struct Stray {
  double most = 0, mean = 0;
  ChartPoint at{0, 0};
};
/// How far `from` strays from the other line.
Stray strays(const std::vector<ChartPoint>& from, bool from_closed, const std::vector<ChartPoint>& to, bool to_closed) {
  Stray s;
  const std::vector<ChartPoint> all = sampled(from, from_closed);
  for (const ChartPoint& p : all) {
    const double d = distance_to_line(to, to_closed, p);
    s.mean += d / double(all.size());
    if (d > s.most) s.most = d, s.at = p;
  }
  return s;
}

double extent(const std::vector<ChartPoint>& path) {
  Vec2 lo = path[0], hi = path[0];
  for (const ChartPoint& p : path) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  return (hi - lo).norm();
}

double angle_at(const ChartPoint& a, const ChartPoint& b, const ChartPoint& c) {
  const Vec2 u = a - b, v = c - b;
  return std::abs(elementary::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v))) * 180 / std::numbers::pi;
}

std::string at_letter(const LessonPlan& plan, const ChartPoint& p) {
  const std::string near = near_letter(plan.letters, p, plan.w);
  return near.empty() ? "" : " " + plan.w("at {}", near);
}

void add_depth_and_blade(Offs& offs, const Words& w, const DrawnLine& want, const DrawnLine& got, bool blade) {
  const double deeper = got.depth_mm - want.depth_mm;
  offs.push_back(
      {Off::depth, std::abs(deeper), kDepth_mm,
       deeper > 0
           ? w("{:.1f} mm deeper than planned ({:.3g} mm): set the depth at the tool", deeper, want.depth_mm)
           : w("{:.1f} mm shallower than planned ({:.3g} mm): set the depth at the tool", -deeper, want.depth_mm)});
  if (!blade) return;
  const double leans = got.angle_deg - want.angle_deg;
  offs.push_back({Off::blade, std::abs(leans), kBlade_deg,
                  std::abs(want.angle_deg - 90) < 1
                      ? w("the blade leans {:.0f}°: hold it upright", std::abs(leans))
                      : w("the blade leans {:.0f}°: hold it at {:.0f}°", std::abs(leans), want.angle_deg)});
}

/// Inner corners of what was planned against the drawn corner nearest to each.
void add_angles(Offs& offs, const LessonPlan& plan, const DrawnLine& want, const DrawnLine& got) {
  const auto corners = [](const DrawnLine& l) {
    return l.closed ? corners_of_outline(l.path) : corners_of_path(l.path);
  };
  const std::vector<ChartPoint> w = corners(want), d = corners(got);
  const size_t n = w.size(), m = d.size();
  Off worst{Off::angle, 0, plan.within.angle_deg, ""};
  for (size_t i = 0; i < n; ++i) {
    if (!want.closed && (i == 0 || i + 1 == n)) continue;
    size_t k = 0;
    for (size_t j = 0; j < m; ++j)
      if ((d[j] - w[i]).norm() < (d[k] - w[i]).norm()) k = j;
    if (m < 3 || (d[k] - w[i]).norm() > kNear_mm || (!got.closed && (k == 0 || k + 1 == m))) continue;
    const double planned = angle_at(w[(i + n - 1) % n], w[i], w[(i + 1) % n]),
                 drawn = angle_at(d[(k + m - 1) % m], d[k], d[(k + 1) % m]);
    if (const double off = std::abs(planned - drawn); off > worst.value)
      worst.value = off,
      worst.words = plan.w("the angle{} is {:.0f}°, planned {:.0f}°", at_letter(plan, w[i]), drawn, planned);
  }
  if (worst.value > 0) offs.push_back(worst);
}

std::optional<Offs> cut_against(const LessonPlan& plan, const DrawnLine& want, const DrawnLine& got, bool blade) {
  if (got.path.size() < 2 || want.path.size() < 2) return std::nullopt;
  const double size = extent(want.path);
  const Stray off_line = strays(got.path, got.closed, want.path, want.closed),
              missing = strays(want.path, want.closed, got.path, got.closed);
  if (off_line.mean > std::max(5.0, 0.3 * size)) return std::nullopt;
  Offs offs;
  const double long_mm = path_length(want.path), drawn_mm = path_length(got.path), short_mm = long_mm - drawn_mm;
  const double may_mm = std::max(plan.within.corner_mm, 0.01 * plan.within.limb_percent * long_mm);
  // A stroke that ends early is told as too short, once.
  const bool is_short = !want.closed && short_mm > may_mm;
  if (!want.closed) {
    const ChartPoint missed = missing.at;
    const std::string towards = at_letter(plan, missed);
    offs.push_back({Off::length, std::abs(short_mm), may_mm,
                    short_mm > 0
                        ? plan.w("{:.0f} mm too short ({:.0f} of {:.0f} mm): the end{} is missing", short_mm, drawn_mm,
                                 long_mm, towards)
                        : plan.w("{:.0f} mm too long ({:.0f} instead of {:.0f} mm)", -short_mm, drawn_mm, long_mm)});
  }
  const NearLetters near = near_letters(plan.letters, off_line.at);
  offs.push_back({Off::line, off_line.most, plan.within.corner_mm,
                  near.second != 0
                      ? plan.w("{:.1f} mm beside the line {}{}", off_line.most, near.first, near.second)
                      : plan.w("{:.1f} mm beside the line{}", off_line.most, at_letter(plan, off_line.at))});
  Off corner{Off::corner, 0, plan.within.corner_mm, ""};
  const std::vector<ChartPoint> corners = want.closed ? corners_of_outline(want.path) : corners_of_path(want.path);
  for (const ChartPoint& c : corners)
    if (const double d = distance_to_line(got.path, got.closed, c); d > corner.value && !is_short)
      corner.value = d, corner.words = plan.w("{:.1f} mm off{}", d, at_letter(plan, c));
  if (corner.value > 0) offs.push_back(corner);
  add_angles(offs, plan, want, got);
  add_depth_and_blade(offs, plan.w, want, got, blade);
  return offs;
}

std::optional<Offs> pocket_against(const LessonPlan& plan, const DrawnLine& want, const DrawnLine& got) {
  if (got.path.size() < 3) return std::nullopt;
  const Stray over = strays(got.path, true, want.path, true), under = strays(want.path, true, got.path, true);
  if (over.mean > std::max(10.0, 0.6 * extent(want.path))) return std::nullopt;
  const double share = area_mm2(got.path) / std::max(1.0, area_mm2(want.path));
  Offs offs;
  if (share < 1)
    offs.push_back({Off::area, 1 - share, 0.3,
                    plan.w("{:.0f} % of the planned pocket is free: undermine further{}", 100 * share,
                           at_letter(plan, under.at))});
  else
    offs.push_back({Off::area, share - 1, 0.5,
                    plan.w("{:.0f} % wider than planned: each mm costs blood supply", 100 * (share - 1))});
  offs.push_back({Off::line, over.most, kPocket_mm + 2 * plan.within.corner_mm,
                  plan.w("{:.0f} mm beside the green line", over.most)});
  add_depth_and_blade(offs, plan.w, want, got, false);
  return offs;
}

/// `from_there`: "{:.0f} mm from where it was planned", in words.
std::optional<Offs> place_against(double far_mm, double may_mm, double attempt_mm, const std::string& from_there) {
  if (!(far_mm < attempt_mm)) return std::nullopt;
  return Offs{{Off::place, far_mm, may_mm, from_there}};
}

double ends_apart(const std::vector<ChartPoint>& p, const std::vector<ChartPoint>& q) {
  return std::max((p.front() - q.front()).norm(), (p.back() - q.back()).norm());
}
std::vector<ChartPoint> turned(std::vector<ChartPoint> p) {
  std::reverse(p.begin(), p.end());
  return p;
}

std::optional<Offs> row_against(const Words& w, const SutureRow& want, const SutureRow& got) {
  if (want.a.empty() || want.b.empty() || got.a.empty() || got.b.empty()) return std::nullopt;
  double far = 1e9;
  for (const bool swap : {false, true})
    for (const bool turn : {false, true}) {
      const auto &a = swap ? got.b : got.a, &b = swap ? got.a : got.b;
      far = std::min(far, std::max(ends_apart(want.a, turn ? turned(a) : a), ends_apart(want.b, turn ? turned(b) : b)));
    }
  constexpr double kRow_mm = 4;
  auto offs = place_against(far, kRow_mm, 12, w("{:.0f} mm from where the row was planned", far));
  if (!offs) return offs;
  const double wider = got.spacing_mm / want.spacing_mm - 1;
  offs->push_back(
      {Off::spacing, std::max(0.0, wider), 0.5,
       w("stitches every {:.1f} mm, planned {:.1f} mm: the edges gape between them", got.spacing_mm, want.spacing_mm)});
  return offs;
}

double off_path(const Vec3& p, const std::vector<Vec3>& path) {
  double far = (p - path.front()).norm();
  for (size_t i = 0; i + 1 < path.size(); ++i) far = std::min(far, distance_to_segment(p, path[i], path[i + 1]));
  return far;
}

/// How far two lines are apart that are drawn in either direction, ends on ends; a hand's has its own posts.
double lines_apart(const std::vector<Vec3>& p, const std::vector<Vec3>& q) {
  if (p.empty() || q.empty()) return 1e9;
  const auto ends = [](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    return std::max((a - c).norm(), (b - d).norm());
  };
  double far = std::min(ends(p.front(), p.back(), q.front(), q.back()), ends(p.front(), p.back(), q.back(), q.front()));
  for (const Vec3& x : p) far = std::max(far, off_path(x, q));
  for (const Vec3& x : q) far = std::max(far, off_path(x, p));
  return far;
}

/// The lines that an act in space runs along: of a row two, of an outline or a cut one, else each place by itself.
std::vector<std::vector<Vec3>> lines_of(const InSpace& c) {
  const std::vector<Vec3> places = places_of(c);
  if (const auto* row = std::get_if<SutureRow>(&c.act)) {
    const auto middle = places.begin() + std::ptrdiff_t(row->a.size());
    return {{places.begin(), middle}, {middle, places.end()}};
  }
  if (std::holds_alternative<Incise>(c.act) || std::holds_alternative<Undermine>(c.act) ||
      std::holds_alternative<Excise>(c.act) || std::holds_alternative<Mark>(c.act))
    return {places};
  std::vector<std::vector<Vec3>> each;
  for (const Vec3& X : places) each.push_back({X});
  return each;
}

/// Acts whose places are in space: line by line, those that have two in either order.
std::optional<Offs> in_space_against(const Words& w, const std::vector<std::vector<Vec3>>& want,
                                     std::vector<std::vector<Vec3>> got, double may_mm) {
  if (want.size() != got.size()) return std::nullopt;
  const auto apart = [&] {
    double far = 0;
    for (size_t k = 0; k < want.size(); ++k) far = std::max(far, lines_apart(want[k], got[k]));
    return far;
  };
  double far = apart();
  std::reverse(got.begin(), got.end());
  far = std::min(far, apart());
  return place_against(far, may_mm, 12, w("{:.0f} mm from where it was planned", far));
}

Vec3 way_of(const RigidMove& by, const Vec3& at) { return isometry(by, at) * at - at; }

std::optional<Offs> bone_against(const Words& w, const PlannedAct& act, const HeadCommand& got) {
  constexpr double kMeant_mm = 40;  // a line that is farther away is not meant for it
  const auto& want = std::get<HeadCommand>(act.command);
  const auto* cut = std::get_if<CutBone>(&want);
  const auto* blade = std::get_if<CutBoneByBlade>(&want);
  if (cut || blade) {
    const auto* sawn = std::get_if<CutBone>(&got);
    if (std::holds_alternative<CutBoneByBlade>(got)) return blade ? plane_against(want, got, w) : std::nullopt;
    if (!sawn) return std::nullopt;
    if (sawn->contour_mm.empty() && (blade || cut->contour_mm.empty())) return plane_against(want, got, w);
    if (sawn->contour_mm.empty()) return Offs{};  // of two kinds: what they came to is judged on the pieces
    double most = 0;
    for (const Vec3& p : sawn->contour_mm) {
      const auto off = beside_line(act, p);
      most = std::max(most, off ? off->norm() : 2 * kMeant_mm);
    }
    if (most > kMeant_mm) return std::nullopt;
    return Offs{{Off::line, most, kSaw_mm, w("{:.0f} mm beside the line on the bone", most)}};
  }
  const auto* move = std::get_if<MoveFragment>(&want);
  if (!move) return want.index() == got.index() ? std::optional(Offs{}) : std::nullopt;
  const Vec3 at = move->fragment.at_mm, planned = way_of(move->by, at);
  Vec3 done = Vec3::Zero(), turned = Vec3::Zero();
  if (const auto* m = std::get_if<MoveFragment>(&got))
    done = way_of(m->by, at), turned = m->by.rotation_deg;
  else if (const auto* d = std::get_if<DragFragment>(&got))
    done = isometry(d->to, Vec3::Zero()) * at - at, turned = d->to.rotation_deg;
  else
    return std::nullopt;
  const Vec3 off = done - planned;
  std::string parts;
  const auto part = [&](double mm, const char* to, const char* from) {
    if (std::abs(mm) < 0.5) return;
    parts += (parts.empty() ? "" : ", ") + w("{:.1f} mm too far {}", std::abs(mm), w(mm > 0 ? to : from));
  };
  part(off.y(), english("forwards"), english("back")), part(off.z(), english("up"), english("down"));
  part(off.x(), english("to the right"), english("to the left"));
  const std::string words = w("the piece went {}", parts);
  return Offs{{Off::way, off.norm(), kPiece_mm, words},
              {Off::angle, (turned - move->by.rotation_deg).norm(), kTurn_deg,
               w("the piece is turned by {:.0f}°, planned {:.0f}°", turned.norm(), move->by.rotation_deg.norm())}};
}

}  // namespace

double distance_to_line(const std::vector<ChartPoint>& path, bool closed, const ChartPoint& p, ChartPoint* on) {
  double best = std::numeric_limits<double>::infinity();
  const size_t n = path.size(), edges = closed ? n : n - 1;
  if (n == 1) {
    if (on) *on = path[0];
    return (p - path[0]).norm();
  }
  for (size_t i = 0; i < edges && n > 1; ++i) {
    const ChartPoint &a = path[i], &b = path[(i + 1) % n];
    const Vec2 e = b - a;
    const double t = std::clamp((p - a).dot(e) / std::max(1e-12, e.squaredNorm()), 0.0, 1.0);
    const ChartPoint q = a + t * e;
    if (const double d = (p - q).norm(); d < best) {
      best = d;
      if (on) *on = q;
    }
  }
  return best;
}

std::optional<DrawnLine> drawn_line(const Command& c) {
  if (const auto* e = std::get_if<Excise>(&c)) return DrawnLine{e->outline, true, e->depth_mm, 90};
  if (const auto* u = std::get_if<Undermine>(&c)) return DrawnLine{u->outline, true, u->depth_mm, 90};
  if (const auto* i = std::get_if<Incise>(&c)) return DrawnLine{i->path, false, i->depth_mm, i->angle_deg};
  return std::nullopt;
}

std::string gentle_word(const Offs& offs) {
  // Causes before what follows from them: a wrong angle takes every later corner along.
  static constexpr Off::Kind kCauses[] = {Off::pieces, Off::length, Off::angle, Off::depth,  Off::blade, Off::spacing,
                                          Off::area,   Off::way,    Off::place, Off::corner, Off::line};
  std::string s;
  int said = 0;
  bool explained = false;  // that the line lies elsewhere
  for (const Off::Kind kind : kCauses)
    for (const Off& o : offs) {
      if (o.kind != kind || o.share() <= 1 || said == 2) continue;
      if (explained && (kind == Off::line || kind == Off::corner)) continue;
      explained |= kind == Off::angle || kind == Off::corner;
      s += (said++ ? "; " : "") + o.words;
    }
  if (!s.empty() && s[0] >= 'a' && s[0] <= 'z') s[0] = char(s[0] - 'a' + 'A');
  return s.empty() ? s : s + ".";
}

std::optional<Offs> against(const LessonPlan& plan, const PlannedAct& planned, const Command& done) {
  if (planned.command.index() != done.index()) return std::nullopt;
  const Words& w = plan.w;
  std::optional<Offs> offs;
  if (const auto want = drawn_line(planned.command)) {
    const auto got = drawn_line(done);
    offs = std::holds_alternative<Undermine>(done)
               ? pocket_against(plan, *want, *got)
               : cut_against(plan, *want, *got, std::holds_alternative<Incise>(done));
  } else if (const auto* h = std::get_if<SetHook>(&planned.command)) {
    const double far = (std::get<SetHook>(done).at - h->at).norm();
    offs = place_against(far, kHook_mm, 15, w("{:.0f} mm from where the hook was planned", far));
  } else if (const auto* m = std::get_if<MoveHook>(&planned.command)) {
    const double far = (std::get<MoveHook>(done).to_mm - m->to_mm).norm();
    offs = place_against(far, kCarried_mm, 30, w("{:.0f} mm from where the hook should be", far));
  } else if (const auto* s = std::get_if<Suture>(&planned.command)) {
    const Suture& d = std::get<Suture>(done);
    const double far = std::min(std::max((d.a - s->a).norm(), (d.b - s->b).norm()),
                                std::max((d.a - s->b).norm(), (d.b - s->a).norm()));
    offs = place_against(far, kBite_mm, 9, w("{:.0f} mm from where the stitch was planned", far));
  } else if (const auto* r = std::get_if<SutureRow>(&planned.command)) {
    offs = row_against(w, *r, std::get<SutureRow>(done));
  } else if (const auto* k = std::get_if<CutThrough>(&planned.command)) {
    offs = in_space_against(w, {k->path}, {std::get<CutThrough>(done).path}, plan.within.corner_mm);
  } else if (const auto* x = std::get_if<InSpace>(&planned.command)) {
    const InSpace& d = std::get<InSpace>(done);
    if (x->act.index() == d.act.index()) offs = in_space_against(w, lines_of(*x), lines_of(d), kBite_mm);
  } else if (std::holds_alternative<HeadCommand>(planned.command)) {
    offs = bone_against(w, planned, std::get<HeadCommand>(done));
  } else {
    offs = Offs{};
  }
  if (offs)
    std::stable_sort(offs->begin(), offs->end(), [](const Off& a, const Off& b) { return a.share() > b.share(); });
  return offs;
}

std::vector<LiveRow> live_rows(const LessonPlan& plan, const PlannedAct& planned, const LiveStroke& stroke) {
  const auto want = drawn_line(planned.command);
  if (!want || stroke.path.size() < 2) return {};
  const Words& w = plan.w;
  const bool pocket = std::holds_alternative<Undermine>(planned.command);
  const double line_mm = pocket ? kPocket_mm + 2 * plan.within.corner_mm : plan.within.corner_mm;
  const double whole = path_length(want->path) + (want->closed ? (want->path.front() - want->path.back()).norm() : 0),
               drawn = path_length(stroke.path);
  std::vector<LiveRow> rows;
  rows.push_back(
      {w("length"), w("{:.0f} of {:.0f} mm", drawn, whole),
       std::max(0.0, drawn - whole) / std::max(plan.within.corner_mm, 0.01 * plan.within.limb_percent * whole)});
  double most = 0;
  for (const ChartPoint& p : stroke.path) most = std::max(most, distance_to_line(want->path, want->closed, p));
  rows.push_back({w("line"), w("{:.1f} mm beside", most), most / line_mm});
  // The direction of the last 4 mm against that of the nearest planned edge, either way round.
  const ChartPoint tip = stroke.path.back();
  size_t back = stroke.path.size() - 1;
  while (back > 0 && (tip - stroke.path[back]).norm() < 4) --back;
  if ((tip - stroke.path[back]).norm() > 2) {
    double best = 1e9, off = 0;
    const Vec2 heading = (tip - stroke.path[back]).normalized();
    const size_t n = want->path.size();
    for (size_t i = 0; i + 1 < n + (want->closed ? 1 : 0); ++i) {
      const ChartPoint &a = want->path[i], &b = want->path[(i + 1) % n];
      if ((b - a).norm() < 1e-6) continue;
      const double d = distance_to_line({a, b}, false, 0.5 * (tip + stroke.path[back]));
      if (d < best)
        best = d, off = std::acos(std::min(1.0, std::abs(heading.dot((b - a).normalized())))) * 180 / std::numbers::pi;
    }
    rows.push_back({w("direction"), w("{:.0f}° off", off), off / (2 * plan.within.angle_deg)});
  }
  if (stroke.depth_mm)
    rows.push_back({w("depth"), w("{:.1f} of {:.1f} mm", *stroke.depth_mm, want->depth_mm),
                    std::abs(*stroke.depth_mm - want->depth_mm) / kDepth_mm});
  if (stroke.angle_deg && std::holds_alternative<Incise>(planned.command))
    rows.push_back(
        {w("blade"), w("{:.0f}°", *stroke.angle_deg), std::abs(*stroke.angle_deg - want->angle_deg) / kBlade_deg});
  return rows;
}

const PlannedAct* meant(const LessonPlan& plan, std::span<const size_t> open, const Command& like,
                        const LiveStroke& stroke) {
  const PlannedAct* best = nullptr;
  double least = 1e9;
  for (const size_t i : open) {
    const PlannedAct& a = plan.acts[i];
    if (a.command.index() != like.index()) continue;
    const auto want = drawn_line(a.command);
    if (!want || stroke.path.empty()) continue;
    double mean = 0;
    for (const ChartPoint& p : stroke.path)
      mean += distance_to_line(want->path, want->closed, p) / double(stroke.path.size());
    if (mean < least) least = mean, best = &a;
  }
  return best;
}

}  // namespace limberg
