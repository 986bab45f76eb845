// Memory that ends in the middle of an act, at any allocation: the act is refused, and the patient is the same to the
// bit.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "sim/patient/world.h"
#include "sim/skull/head/head.h"
#include "sim/skull/simplex/generators.h"
#include "tests/sim/patient/small_block.h"

namespace {

// The allocation from now on that fails, once; below 0: none does.
int64_t fails_at = -1;
int64_t allocations = 0;

void* allocate(size_t n) {
  if (allocations++ == fails_at) throw std::bad_alloc();
  if (void* p = std::malloc(n > 0 ? n : 1)) return p;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(size_t n) { return allocate(n); }
void* operator new[](size_t n) { return allocate(n); }
void* operator new(size_t n, const std::nothrow_t&) noexcept {
  return allocations++ == fails_at ? nullptr : std::malloc(n > 0 ? n : 1);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
void operator delete[](void* p, size_t) noexcept { std::free(p); }

namespace limberg {
namespace test_memory {

constexpr int kTries = 50;  // of each act, spread over its allocations

/// The outcome, with allocation number `at` of the act failing.
Outcome with_fault(World& world, const Command& act, int64_t at) {
  allocations = 0, fails_at = at;
  Outcome o;
  try {
    o = world.apply(act);
  } catch (...) {
    fails_at = -1;
    throw;
  }
  fails_at = -1;
  return o;
}

/// Tries `act` with faults; `back` is what takes it back. The patient is then as it was before.
void try_faults(World& world, const Command& act, const Command& back) {
  const uint64_t before = world.full_hash();
  int64_t all = 0;
  uint64_t after = 0;
  for (int i = 0; i < 2; ++i) {  // what the first time has found, and keeps, asks for no memory later
    const Outcome done = with_fault(world, act, -1);
    ASSERT_TRUE(done.done) << done.reason;
    all = allocations;
    after = world.full_hash();
    ASSERT_TRUE(world.apply(back).done);
    ASSERT_EQ(world.full_hash(), before);
  }
  int refused = 0;
  for (int i = 0; i < kTries; ++i) {
    const int64_t at = all * i / kTries;
    const Outcome o = with_fault(world, act, at);
    const std::string where = "allocation " + std::to_string(at) + " of " + std::to_string(all) + ": " + o.reason;
    if (o.done) {  // another way was found
      ASSERT_EQ(world.full_hash(), after) << where;
      ASSERT_TRUE(world.apply(back).done);
    } else {
      ++refused;
      EXPECT_NE(o.reason.find("failed inside"), std::string::npos) << where;
    }
    ASSERT_EQ(world.full_hash(), before) << where;
  }
  EXPECT_GE(refused, kTries / 2) << "of " << all << " allocations";
}

/// Each act with faults, and its undo and redo with faults; then it stays.
void try_all(World& world, const std::vector<std::pair<const char*, Command>>& acts) {
  for (const auto& [name, act] : acts) {
    SCOPED_TRACE(name);
    ASSERT_NO_FATAL_FAILURE(try_faults(world, act, Undo{}));
    ASSERT_TRUE(world.apply(act).done);
    {
      SCOPED_TRACE("undo");
      ASSERT_NO_FATAL_FAILURE(try_faults(world, Undo{}, Redo{}));
    }
    ASSERT_TRUE(world.apply(Undo{}).done);
    {
      SCOPED_TRACE("redo");
      ASSERT_NO_FATAL_FAILURE(try_faults(world, Redo{}, Undo{}));
    }
    ASSERT_TRUE(world.apply(Redo{}).done);
  }
}

TEST(Memory, AnActOnSkinIsWholeOrNotThere) {
  InlineWorkers workers;
  World world(test::small_block({.side_mm = 50, .fat = false}), workers);
  StepSettings s;
  s.max_iterations = 5;
  world.step(s);
  try_all(world, {{"incision", Incise{{{0.3, -17}, {-0.4, 16}}, 4, 90}},
                  {"incision across it", Incise{{{-15, 0.3}, {15, 0.9}}, 4, 80}},
                  {"undermining", Undermine{{{-1, -8}, {12, -8}, {12, 8}, {-1, 8}}, 4}},
                  {"excision", Excise{{{-7, 4}, {6, 4}, {7, 12}, {-6, 11}}, 4}},
                  {"stitch", Suture{{-2, -10}, {2, -10}}}});
}

// Each piece of a stroke that is being drawn; where one fails the stroke has stopped, and what was cut stays.
TEST(Memory, APieceOfADrawnStrokeIsWholeOrNotThere) {
  InlineWorkers workers;
  World world(test::small_block({.side_mm = 50, .fat = false}), workers);
  const uint64_t uncut = world.full_hash();
  const auto piece = [](int stroke, double from, double to, bool last) {
    return InciseMore{stroke, {{from, -12}, {(from + to) / 2, -11.5}, {to, -11}}, 4, 90, last};
  };
  ASSERT_TRUE(world.apply(piece(1, -16, 0, false)).done);
  const uint64_t half = world.full_hash();
  ASSERT_NE(half, uncut);
  ASSERT_TRUE(with_fault(world, piece(1, 0.5, 15, true), -1).done);
  const int64_t all = allocations;
  const uint64_t whole = world.full_hash();
  ASSERT_TRUE(world.apply(Undo{}).done);
  for (int i = 0; i < kTries; ++i) {
    const int64_t at = all - 1 - (all - 1) * i / (8 * kTries);  // the end is where a piece joins the one before it
    ASSERT_EQ(world.full_hash(), uncut);
    ASSERT_TRUE(world.apply(piece(i + 2, -16, 0, false)).done);
    const Outcome o = with_fault(world, piece(i + 2, 0.5, 15, true), at);
    ASSERT_EQ(world.full_hash(), o.done ? whole : half) << "allocation " << at << " of " << all << ": " << o.reason;
    ASSERT_TRUE(world.apply(Undo{}).done);
  }
}

ConnectTissue tissue(const char* name, double side) {
  ConnectTissue t;
  t.name = name, t.face_mm = {0, 0, 38 * side}, t.bone_mm = {0, 0, 30 * side}, t.face_radius_mm = 25, t.layers = 2;
  return t;
}

HeadParts ball(bool face) {
  HeadParts p;
  p.bones.push_back({"ball", simplex::make_sphere({0, 0, 0}, 30, 3), false});
  p.bones.push_back({"anvil", simplex::make_sphere({0, 0, -200}, 20, 2), true});
  p.landmarks = {{"top", {0, 0, 30}, false}, {"bottom", {0, 0, -30}, false}};
  if (!face) return p;
  p.face = simplex::make_sphere({0, 0, 0}, 38, 3);
  simplex::record_shape(p.face);
  p.landmarks.push_back({"crown", {0, 0, 38}, true});
  p.tissues.push_back(tissue("cap", 1));
  return p;
}

TEST(Memory, AnActOnAHeadIsWholeOrNotThere) {
  InlineWorkers workers;
  CutBone halve;
  halve.point_mm = {0, 0, 5}, halve.normal = Vec3::UnitZ();
  MoveFragment lift;
  lift.fragment.at_mm = {0, 0, 30}, lift.by.translation_mm = {0, 0, 2};
  PlateFragments plate{{0, 29, 8}, {0, 29, 2}};
  Unplate unplate;
  unplate.fragment.at_mm = {0, 0, 30};
  JoinFragments join;
  join.a.at_mm = {0, 0, 30}, join.b.at_mm = {0, 0, -30};
  PlaceLandmark landmark;
  landmark.name = "side", landmark.at_mm = {0, 30, 0};
  World with_face(ball(true), workers);
  try_all(with_face, {{"landmark", HeadCommand(landmark)},
                      {"tissue", HeadCommand(tissue("chin", -1))},
                      {"osteotomy", HeadCommand(halve)},
                      {"plate", HeadCommand(plate)},
                      {"plate off", HeadCommand(unplate)},
                      {"join", HeadCommand(join)}});
  // A face follows the bones and is not set back by a move (head.h), so the moves are those of a head without one.
  World without_face(ball(false), workers);
  try_all(without_face, {{"osteotomy", HeadCommand(halve)}, {"move", HeadCommand(lift)}, {"join", HeadCommand(join)}});
}

}  // namespace test_memory
}  // namespace limberg
