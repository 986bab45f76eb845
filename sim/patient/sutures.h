#pragma once
// Stitches and threads: tying, drawing tight, cutting, and what they pull with.
//
// A stitch is a spring between two bites. It is drawn tight over some steps (its slack shrinks), as a hand does it. A
// running suture, drawn at once or sewn bite after bite, is one thread through many bites, which slides until its
// tension is the same everywhere (fem/forces/spring_forces.h).
//
// Whoever sews bite after bite holds the thread's end. Once it is let go untied, only friction holds the thread. It
// winds about the edges like a helix, once a stitch, so that its tangent turns by 2 pi from one stitch to the next, and
// by pi from the last stitch to the free end. Over a turn of theta a thread slips unless (Euler and Eytelwein)
//
//   T_towards_the_first_knot <= T_towards_the_free_end * exp(mu theta)      and the other way round,
//
// and the end itself holds kFreeEnd_N (thread_friction.h). A stitch pulls with at most 0.05, 0.34, 2.2 N, counted from
// the end: those near it part, and those some turns behind it stay. What lies in each is its own (Stitch::own_mm); what
// slips into one comes out of the next, into the last out of the free end. What lies along the wound stays where it
// is, as before.
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/commands/command.h"
#include "sim/patient/tissue.h"

namespace limberg {

class Sutures {
 public:
  Sutures(const Tissue& tissue, Holding& holding) : tissue_(tissue), holding_(holding) {}

  Outcome act(const Suture& c);
  Outcome act(const SutureRow& c);
  Outcome act(const SutureCorner& c);
  Outcome act(const SutureBetween& c);
  Outcome act(const CutSuture& c);
  Outcome act(const SutureBite& c);
  Outcome act(const TieSuture& c);
  Outcome act(const LetThreadGo& c);

  /// What the stitch that has `between` others between itself and the free end can pull with, at most, in N.
  static double held_by_friction_N(int between);

  /// The thread that is sewn bite after bite, and where its last bite came out; nothing: none is.
  std::optional<SewnThread> sewn() const;

  bool draw_tight();  // by one step; true when something moved
  bool settled() const;
  /// How far the ends that are still being drawn together are apart, at most; 0 once all are.
  double to_draw_mm() const;
  /// Forces of a state at rest: the first of a stitch and the largest.
  void note_forces();
  /// To the present version of the topology; a thread that has lost a bite goes.
  void carry();
  /// Stitches that join no two banks: the straight way from bite to bite, at rest, runs along one edge of
  /// a wound, over skin. O(stitches x rim)
  std::vector<int> in_one_bank() const;

 private:
  /// Of a stitch's bite: on the rim near p, or so deep in the wall below it.
  std::optional<Anchor> find_bite(const ChartPoint& p, double depth_mm, std::string& reason,
                                  HeldSide side = HeldSide::skin) const;
  std::optional<Anchor> bite_at(const SurfacePoint& rim, double depth_mm, std::string& reason) const;
  /// Of a bite that counts by how far from the edge it lies: on the rim, with that distance as its bite.
  std::optional<Anchor> find_own_bite(const ChartPoint& p, double depth_mm, HeldSide side, std::string& reason) const;
  Thread* sewn_thread();
  std::string through_whole_skin(const Anchor& a, const Anchor& b) const;  // a note; empty: neither bite does
  /// Index into the stitches.
  std::optional<size_t> find_stitch(const StitchPick& pick, std::string& reason) const;
  void widen(Anchor& bite) const;
  Stitch between(const Anchor& a, const Anchor& b, double bite_mm) const;  // without numbers, open as it lies
  Outcome sew_row(const std::vector<std::pair<Anchor, Anchor>>& bites, const RowKind& kind, bool whole);
  /// One thread through these spans in their order.
  void thread_through(std::vector<Stitch> spans, bool corner, double slack_mm);
  /// Further spans of a thread that is there, behind its last one: it is drawn anew.
  void go_on(Thread& thread, std::vector<Stitch>::iterator where, std::vector<Stitch> spans);
  /// The way of a thread from one stitch to the next, which it keeps.
  Vec3 along_the_wound(const Stitch& before, const Stitch& next) const;
  void draw(Thread& thread) const;
  /// One step of a thread that was let go; `closing` afterwards: it has slipped.
  void slip(Thread& thread);
  /// A hand takes it up again: it slides as one, from where friction had held it.
  void take_up(Thread& thread);
  void drop_thread(int32_t thread);  // and its spans
  bool same_place(const Anchor& a, const Anchor& b) const;
  bool joins(const Stitch& stitch, const Anchor& a, const Anchor& b) const;  // the same two places, either way round

  const Tissue& tissue_;
  Holding& holding_;
};

/// Of hooks and stitches, as the solver gets them.
std::vector<Spring> springs(const Holding& holding, const WorldSpec& spec);

}  // namespace limberg
