#include "tests/app/window/sawn_head.h"
#include "tests/sim/skull/needs_bullet.h"
namespace limberg {
namespace test_try_saw {
using namespace sawn_head;
void try_one(const std::string& name, int acts) {
  const Told told = say_of(name, [&](const SurfaceTopology& t, const HeadCommand&) {
    std::vector<Deed> deeds;
    int n = 0;
    for (const Command& c : test::shipped_commands(name))
      if (const auto* h = std::get_if<HeadCommand>(&c); h && n++ < acts)
        for (const auto& l : planned_lines(t, *h)) {
          double len = 0; for (size_t i = 1; i < l.size(); ++i) len += (l[i]-l[i-1]).norm();
          Vec3 lo = l[0], hi = l[0]; for (auto& p : l) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
          std::printf("curve %zu points %.0f mm closes %.0f  x %.0f..%.0f y %.0f..%.0f z %.0f..%.0f\n", l.size(), len, (l[0]-l.back()).norm(), lo.x(),hi.x(),lo.y(),hi.y(),lo.z(),hi.z());
          deeds.push_back({round(l), {}});
        }
    return deeds;
  });
  std::puts(told.all.c_str());
  for (auto& r : told.refused) std::printf("refused: %s\n", r.c_str());
  std::printf("first done %d\n", told.first_done);
}
TEST(TrySaw, LeFort1) { try_one("le_fort_1", 1); }
TEST(TrySaw, LeFort3) { try_one("le_fort_3", 1); }
TEST(TrySaw, Cranio) { try_one("craniofacial", 1); }
TEST(TrySaw, Sagittal) { try_one("sagittal_split", 2); }
TEST(TrySaw, Bico) { try_one("bicoronal", 1); }
}
}
