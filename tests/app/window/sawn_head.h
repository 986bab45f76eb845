#pragma once
// A hand that saws on a shipped head, and what the window says to it. With LIMBERG_PICTURES=DIR in the environment the
// window is drawn into files at every word.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include "app/assembly/assembly.h"
#include "app/pictures/pictures.h"
#include "app/program/places.h"
#include "app/session/lockstep.h"
#include "app/teaching/saw_watch.h"
#include "app/window/window_frames.h"
#include "devices/emulator.h"
#include "sim/commands/script.h"
#include "sim/geometry/polyline.h"
#include "tests/app/window/drawn_window.h"
#include "tests/sim/commands/shipped_scripts.h"

namespace limberg::sawn_head {

/// One thing that the hand does: the saw pressed down and led along a way, or something told.
struct Deed {
  std::vector<Vec3> way_mm;
  std::optional<Command> told;
};

/// A steady hand: 0.6 s down, 40 mm/s along, up again.
class SawHand final : public Source {
 public:
  explicit SawHand(std::vector<Deed> deeds) : deeds_(std::move(deeds)) {}
  void poll(int64_t now_ns, SampleSink& sink) override {
    if (next_ == deeds_.size()) return;
    const Deed& d = deeds_[next_];
    if (began_ns_ < 0) begin(d, now_ns, sink);
    const double t_s = double(now_ns - began_ns_) * 1e-9;
    for (; double(sent_) * 0.01 <= t_s && !d.way_mm.empty(); ++sent_) stylus(d, double(sent_) * 0.01, sink);
    if (t_s > lasts_s_) ++next_, began_ns_ = -1;
  }
  bool done() const override { return next_ == deeds_.size(); }
  SourceCounts counts() const override { return {seq_, 0, 0}; }

 private:
  static constexpr double kDown_s = 0.6, kUp_s = 1.5, kSpeed_mm_s = 40;
  void begin(const Deed& d, int64_t now_ns, SampleSink& sink) {
    began_ns_ = now_ns, sent_ = 0, lasts_s_ = 1.5;
    if (d.told && !std::holds_alternative<Undo>(*d.told)) {
      CommandSample c = command_sample(*d.told);
      c.device_id = 1, c.seq = seq_++, c.t_ns = now_ns;
      return sink.on_sample(c);
    }
    ControlSample c;
    c.device_id = 1, c.seq = seq_++, c.t_ns = now_ns;
    c.kind = d.told ? ControlSample::undo : ControlSample::select_tool, c.tool = Tool::saw;
    sink.on_sample(c);
    long_mm_ = 0;
    for (size_t i = 1; i < d.way_mm.size(); ++i) long_mm_ += (d.way_mm[i] - d.way_mm[i - 1]).norm();
    if (!d.way_mm.empty()) lasts_s_ = kDown_s + long_mm_ / kSpeed_mm_s + kUp_s;
  }
  void stylus(const Deed& d, double t_s, SampleSink& sink) {
    StylusSample s;
    s.device_id = 1, s.seq = seq_++, s.t_ns = began_ns_ + int64_t(t_s * 1e9);
    double left = std::clamp((t_s - kDown_s) * kSpeed_mm_s, 0.0, long_mm_);
    s.tip_mm = d.way_mm.back();
    for (size_t i = 1; i < d.way_mm.size(); ++i) {
      const Vec3 step = d.way_mm[i] - d.way_mm[i - 1];
      if (left <= step.norm()) {
        s.tip_mm = d.way_mm[i - 1] + left / std::max(1e-9, step.norm()) * step;
        break;
      }
      left -= step.norm();
    }
    s.buttons = t_s > kDown_s - 0.2 && t_s < kDown_s + long_mm_ / kSpeed_mm_s + 0.3;
    if (!s.buttons) s.tip_mm += Vec3(0, 15 * std::min(1.0, std::abs(t_s - kDown_s + 0.2) / 0.3), 0);
    sink.on_sample(s);
  }
  std::vector<Deed> deeds_;
  size_t next_ = 0, sent_ = 0;
  int64_t began_ns_ = -1, seq_ = 0;
  double lasts_s_ = 0, long_mm_ = 0;
};

/// Where a plane cuts the surface of a fragment, as closed lines.
inline std::vector<std::vector<Vec3>> section(const SurfaceTopology& t, int32_t object, const Vec3& at,
                                              const Vec3& normal) {
  const SurfaceView& v = t.view;
  const auto height = [&](int32_t p) { return (v.X_mm[size_t(p)] - at).dot(normal) + 1e-7; };
  using Edge = std::pair<int32_t, int32_t>;
  std::map<Edge, std::vector<Edge>> next;
  std::map<Edge, Vec3> place;
  for (size_t k = 0; k < v.tri.size(); ++k) {
    if (t.object.empty() || t.object[k] != object) continue;
    std::vector<Edge> crossed;
    for (size_t c = 0; c < 3; ++c) {
      const int32_t p = std::min(v.tri[k][c], v.tri[k][(c + 1) % 3]), q = std::max(v.tri[k][c], v.tri[k][(c + 1) % 3]);
      const double hp = height(p), hq = height(q);
      if (hp * hq >= 0) continue;
      place[{p, q}] = v.X_mm[size_t(p)] + hp / (hp - hq) * (v.X_mm[size_t(q)] - v.X_mm[size_t(p)]);
      crossed.emplace_back(p, q);
    }
    if (crossed.size() == 2) next[crossed[0]].push_back(crossed[1]), next[crossed[1]].push_back(crossed[0]);
  }
  std::vector<std::vector<Vec3>> lines;
  while (!next.empty()) {
    std::vector<Vec3> line;
    Edge e = next.begin()->first;
    while (next.count(e)) {
      line.push_back(place[e]);
      const std::vector<Edge> on = next[e];
      next.erase(e);
      for (const Edge& o : on)
        if (next.count(o)) e = o;
    }
    lines.push_back(std::move(line));
  }
  return lines;
}
/// Where a planned cut runs on its bone, as closed lines, from one place to the nearest next.
inline std::vector<std::vector<Vec3>> planned_lines(const SurfaceTopology& t, const HeadCommand& cut) {
  constexpr double kGap_mm = 4, kLeast_mm = 20;
  std::vector<Vec3> left = line_on_bone(t, cut);
  std::vector<std::vector<Vec3>> lines;
  while (!left.empty()) {
    std::vector<Vec3> line{left.back()};
    left.pop_back();
    while (!left.empty()) {
      const auto next = std::min_element(left.begin(), left.end(), [&](const Vec3& a, const Vec3& b) {
        return (a - line.back()).squaredNorm() < (b - line.back()).squaredNorm();
      });
      if ((*next - line.back()).norm() > kGap_mm) break;
      line.push_back(*next), left.erase(next);
    }
    if (double(line.size()) > kLeast_mm) lines.push_back(std::move(line));
  }
  return lines;
}
/// That which goes round the foremost place.
inline std::vector<Vec3> foremost(const std::vector<std::vector<Vec3>>& lines) {
  const std::vector<Vec3>* best = nullptr;
  double most = -1e9;
  for (const auto& l : lines)
    for (const Vec3& p : l)
      if (std::abs(p.x()) < 8 && p.y() > most) most = p.y(), best = &l;
  return best ? *best : std::vector<Vec3>{};
}
/// Closed, from its hindmost place on, and a little beyond it.
inline std::vector<Vec3> round(std::vector<Vec3> line) {
  if (line.empty()) return line;
  const auto back = std::min_element(line.begin(), line.end(), [](auto& a, auto& b) { return a.y() < b.y(); });
  std::rotate(line.begin(), back, line.end());
  line.push_back(line.front());
  return line;
}
/// Its front, from the right to the left.
inline std::vector<Vec3> front(const std::vector<Vec3>& line, double half_mm) {
  std::vector<Vec3> out;
  for (double x = -half_mm; x <= half_mm; x += 2) {
    const Vec3* best = nullptr;
    for (const Vec3& p : line)
      if (std::abs(p.x() - x) < 2.5 && (!best || p.y() > best->y())) best = &p;
    if (best) out.push_back(*best);
  }
  return out;
}

class Watched final : public PictureSink {
 public:
  Watched(testing::MemoryScreen& screen, WindowFrames& window, std::string pictures)
      : screen_(screen), window_(window), pictures_(std::move(pictures)) {}
  void prepare(const SurfaceTopology& first) override { window_.prepare(first); }
  void notice(const Notice& n) override { window_.notice(n); }
  void missed(const MissedPress& m, const Snapshot& s) override { window_.missed(m, s); }
  bool wants_frame() override { return true; }
  void stage(const std::string&, const Snapshot&) override {}
  void finish() override { window_.finish(); }
  void frame(const Snapshot& s, const ToolState& t) override {
    if (++calls_ % (pictures_.empty() ? 15 : 5) != 0) return;
    window_.wants_frame();
    window_.frame(s, t);
    const size_t said = window_.coach()->said().size();
    if (pictures_.empty() || said == said_) return;
    said_ = said;
    for (int i = 0; i < 4; ++i) window_.wants_frame(), window_.frame(s, t);
    write_png(pictures_ + "/saw-" + std::to_string(1000 + ++shots_).substr(1) + ".png", window_.picture());
  }

 private:
  testing::MemoryScreen& screen_;
  WindowFrames& window_;
  std::string pictures_;
  int calls_ = 0, shots_ = 0;
  size_t said_ = 0;
};

struct Told {
  std::string all;
  std::vector<std::string> refused;
  bool first_done = false;
  size_t bones = 0;  // at the end
};

/// The lesson's scene, with what the hand does there.
template <class Deeds>
Told say_of(const std::string& name, Deeds&& deeds) {
  const Lesson lesson = open_lesson(source_dir() + "/app/lessons/" + name + ".toml");
  Scene scene = load_scene(source_dir() + "/app/scenes/" + lesson.scene + ".toml");
  const char* pictures = std::getenv("LIMBERG_PICTURES");
  if (!pictures) scene.head->face = false, scene.head->tissues.clear(), scene.head->face_landmarks.clear();
  const std::vector<Command> script = test::shipped_commands(name);
  testing::MemoryScreen screen;
  HandFeed feed;
  WindowSettings set;
  set.facts.scene = scene.name, set.facts.device = "stylus", set.facts.own_device = set.facts.calibrated = true;
  set.facts.goal = lesson.goal, set.facts.skin = false, set.facts.head = true;
  set.camera = scene_camera(scene), set.lesson = make_lesson_plan(&lesson, script);
  WindowFrames window(screen, feed, nullptr, set);
  Watched watched(screen, window, pictures ? pictures : "");
  AssemblyOptions o;
  o.workers = 1, o.sink = &watched, o.draw_frames = true;
  Assembly a(scene, Calibration{}, o);
  Snapshot first;
  a.patient->fill(first);
  const HeadCommand* planned = nullptr;
  for (const Command& c : script)
    if (const auto* h = std::get_if<HeadCommand>(&c); h && !planned) planned = h;
  a.front.add(std::make_unique<SawHand>(deeds(*first.topology, *planned)));
  SessionSettings s = a.session_settings();
  s.ticks_per_frame = 33, s.settle_steps = 0;
  run_lockstep(a.lanes(nullptr), s);
  Told told;
  for (const Coach::Said& w : window.coach()->said())
    told.all += "  " + std::to_string(w.t_s).substr(0, 5) + "  " + w.word + "\n";
  for (const Refusal& r : a.solver.refused()) told.refused.push_back(r.reason);
  told.first_done = window.coach()->progress().act[0].state == ActProgress::done;
  if (pictures) std::puts(told.all.c_str());
  Snapshot end;
  a.patient->fill(end);
  std::set<int32_t> bones;
  for (size_t k = 0; k < end.topology->view.tri.size(); ++k)
    if (end.topology->is_ground(k, Ground::bone)) bones.insert(end.topology->object[k]);
  told.bones = bones.size();
  return told;
}

inline void expect_in_order(const std::string& all, std::initializer_list<const char*> words) {
  size_t from = 0;
  for (const char* w : words) {
    const size_t at = all.find(w, from);
    EXPECT_NE(at, std::string::npos) << "not said, or too early: " << w << "\nsaid:\n" << all;
    if (at != std::string::npos) from = at;
  }
}

}  // namespace limberg::sawn_head
