#include "sim/imaging/anatomical/norms.h"

namespace limberg::anatomical {

std::span<const Norm> norms() {
  static constexpr Norm all[] = {
      {"head length", "g'", "op'", 197.1, 7.1, "Farkas 1994"},
      {"head breadth", "eu'_R", "eu'_L", 151.1, 5.7, "Farkas 1994"},
      {"face breadth", "zy'_R", "zy'_L", 137.1, 4.3, "Farkas 2005"},
      {"face height", "n'", "me'", 124.7, 5.7, "Farkas 1994, n-gn"},
      {"lower face height", "sn", "me'", 72.6, 4.5, "Farkas 1994, sn-gn"},
      {"nose height", "n'", "sn", 54.8, 3.3, "Farkas 1994"},
      {"nose breadth", "al_R", "al_L", 34.9, 2.1, "Farkas 2005"},
      {"nose protrusion", "sn", "prn", 19.5, 1.9, "Farkas 1994"},
      {"intercanthal", "en_R", "en_L", 33.3, 2.7, "Farkas 2005"},
      {"biocular", "ex_R", "ex_L", 91.2, 3.0, "Farkas 2005"},
      {"mouth", "ch_R", "ch_L", 54.5, 3.0, "Farkas 2005"},
      {"upper lip height", "sn", "sto", 22.3, 2.1, "Farkas 1994"},
      {"ear length", "sa_R", "sba_R", 62.7, 3.6, "Farkas 1994"},
  };
  return all;
}

}  // namespace limberg::anatomical
