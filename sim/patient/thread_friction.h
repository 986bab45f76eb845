#pragma once
// How a thread is held by the tissue that it runs through. One law for the hand that draws it (force/tool_feel.h) and
// for a thread that nobody holds (sutures.h): over a turn of theta it slips only where (Euler, Eytelwein)
//
//   T_ahead > T_behind * exp(kThreadFriction * theta)
//
// A hand that draws it feels the drag of the bite's channel, kThreadDrag_N, behind it. Of a thread that was laid down
// untied the end lies loose on wet skin, and needle and thread hold with kFreeEnd_N.
//
// Sutures on artificial skin were measured about a capstan by Zhang, Ren, Zeng and van der Heide, Friction 5 (2017) 87,
// on tissue of pigs by Zhang, Li, Lin and Zhou, Tribol. Lett. 65 (2017): friction falls with load, in wet tissue and by
// a coating. The three numbers are chosen in that light, not measured.
namespace limberg {

inline constexpr double kThreadFriction = 0.3, kThreadDrag_N = 0.15, kFreeEnd_N = 0.02;

}  // namespace limberg
