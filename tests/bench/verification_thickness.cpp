// Skin in a lattice that does not fit it: as thick as it says, and as soft under a hook's patch.
#include <fmt/format.h>

#include "app/operating_point/cpu_clock.h"
#include "tests/bench/verification_parts.h"
#include "tests/sim/lattice/sheet_lattice.h"

namespace limberg::bench {

namespace {

using test::kSkin_mm;
using test::SheetLattice;

// CalculiX 2.20, 20-node hexahedra, the limit of 1,225 to 55,725 nodes on a quarter (2026-11-24): docs/validation.md.
constexpr double kAlong_mm = 1.820, kUpwards_mm = 1.769;

}  // namespace

void thickness(Result& out, const VerificationSettings& set) {
  const std::vector<double> sizes = set.quick ? std::vector<double>{5} : std::vector<double>{5, 3.5, 2};
  double worst = 0;
  const auto row = [&](const char* body, const std::string& how, double acts_mm, double before) {
    const double off = 100 * (acts_mm / kSkin_mm - 1);
    worst = std::max(worst, std::fabs(off));
    out.rows.push_back({fmt::format("1.5 mm of skin on a {}", body), "cut cells", how, cpu_ms() - before, false, off,
                        "%", "the body's own volume", true});
  };
  const Body ball = test::layered(test::ball_mesh(30, 5, {0.3, 0.7, -0.4}), kSkin_mm, true);
  const double whole = test::skin_of_ball_mm3(ball.surface, kSkin_mm);
  for (const double h : sizes) {
    const double before = cpu_ms();
    row("ball of radius 30 mm", fmt::format("cells of {} mm", h),
        kSkin_mm * test::skin_mass(SheetLattice(ball, h)) / whole, before);
  }
  const Body slab = test::layered(test::slab(0).surface, kSkin_mm, true);
  for (const double h : sizes)
    for (const double off : set.quick ? std::vector<double>{0.4} : std::vector<double>{0, 0.2, 0.4, 0.6, 0.8}) {
      const double before = cpu_ms();
      row("slab", fmt::format("cells of {} mm, planes {} of a cell higher", h, off),
          test::skin_mass(SheetLattice(slab, h, {0.5 * off, 0.3 * off, off})) / 3600, before);
    }
  at_most(out, "thickness of skin: largest error (%)", worst, 2, "2 % at 5 mm is the aim; the volume is known exactly");
  if (set.quick) return;
  for (const double h : {5.0, 3.5}) {
    double along = 0, upwards = 0;
    for (const bool block : {true, false})
      for (const double off : block ? std::vector<double>{0} : std::vector<double>{0, 0.4, 0.8}) {
        const double before = cpu_ms();
        const SheetLattice l =
            block ? SheetLattice(test::as_block(test::slab(0)), h) : SheetLattice(test::slab(0), h, {0.5, 0.5, off});
        const double x = 100 * (50 * patch_move(l, {0.02, 0, 0}).x() / kAlong_mm - 1),
                     z = 100 * (50 * patch_move(l, {0, 0, 0.01}).z() / kUpwards_mm - 1);
        along = std::max(along, std::fabs(x)), upwards = std::max(upwards, std::fabs(z));
        out.rows.push_back({"skin on fat, a patch of 6 mm pulled along", block ? "block" : "closed surface",
                            fmt::format("cells of {} mm, upwards off by {:.1f} %", h, z), cpu_ms() - before, false, x,
                            "%", "CalculiX, 20-node hexahedra", true});
      }
    const double bar = h == 5 ? 5 : 3;
    at_most(out, fmt::format("skin on fat at {} mm, along: largest error (%)", h), along, bar, "aim: 3 % at 3.5 mm");
    at_most(out, fmt::format("skin on fat at {} mm, upwards: largest error (%)", h), upwards, bar,
            "aim: 3 % at 3.5 mm");
  }
}

}  // namespace limberg::bench
