#pragma once
// What each tool meets in tissue, beside the elastic tissue that the solver answers for (model_maker.h).
//
// Resistance is work: to part tissue of toughness R (1 kJ/m^2 = 1 N/mm) along a front of width w takes R w newtons, and
// R w / (1 + x^2) where the edge slides x mm along itself for each mm that it goes on (Atkins, Xu and Jeronimidis, J.
// Mater. Sci. 39 (2004) 2761). So
//   scalpel, excise  breaks through, and is then held back along the surface by R d / (1 + x^2): the deeper, the more.
//                    R = 1.7 N/mm, skin cut by scissors (Pereira, Lucas and Teaford, J. Biomech. 30 (1997) 91);
//                    x = 1, an edge at 45 degrees to its way
//   undermine        a front as wide as the tool, whatever its depth: R = 4.1 N/mm, fat (Comley and Fleck, Int. J.
//                    Solids Struct. 47 (2010) 2982); x = 2, an edge that is swept from side to side
//   suture           the needle breaks through, goes on with less, and draws a thread (below). Tearing is R w with 1.14
//                    N/mm for a needle in skin and its width, and 61 % of the whole; friction 21 % (Barnett, Lee and
//                    Moore, J. Manuf. Sci. Eng. 138 (2016) 011005)
//   thread           comes out of its hole along the normal and is bent to where it is pulled, by an angle a: T = T0
//                    exp(mu a) (Euler's capstan; of sutures on skin: Zhang, Ren, Zeng and van der Heide, Friction 5
//                    (2017) 87). T0, the drag in the channel, and mu are chosen, not measured
//   others           are blunt: nothing of this
// What is chosen: the widths of the tools, x, T0 and mu; and of a scalpel what it takes to break through and to go
// deeper (ForceSourceSettings).
#include "devices/sample.h"

namespace limberg {

struct ToolFeel {
  double puncture_N = 0, cutting_N = 0;  // to break through; to go deeper from then on
  double draw_N = 0, draw_N_mm = 0;      // along the surface, and more for each mm of depth
  bool drawn_when_pressed = false;       // held back while the button is down, and not only once it has broken through
  bool presses = false;                  // what has broken through is engaged, with or without a button
  double thread_N = 0, thread_friction = 0;
};

inline ToolFeel feel_of(Tool tool, double scalpel_puncture_N, double scalpel_cutting_N) {
  constexpr double kSkin_N_mm = 1.7, kNeedleInSkin_N_mm = 1.14, kFat_N_mm = 4.1;
  constexpr double kDissector_mm = 2, kNeedle_mm = 0.6, kTearing = 0.61, kFriction = 0.21;
  const auto sliced = [](double along) { return 1 / (1 + along * along); };
  ToolFeel f;
  switch (tool) {
    case Tool::scalpel:
    case Tool::scalpel_through:
    case Tool::excise:
      f.puncture_N = scalpel_puncture_N, f.cutting_N = scalpel_cutting_N;
      f.draw_N_mm = kSkin_N_mm * sliced(1);
      f.presses = true;
      break;
    case Tool::undermine:
      f.draw_N = kFat_N_mm * kDissector_mm * sliced(2);
      f.drawn_when_pressed = true;
      break;
    case Tool::suture:
      f.puncture_N = kNeedleInSkin_N_mm * kNeedle_mm / kTearing;
      f.cutting_N = (kTearing + kFriction) * f.puncture_N;
      f.thread_N = 0.15, f.thread_friction = 0.3;
      break;
    default:
      break;
  }
  return f;
}

}  // namespace limberg
