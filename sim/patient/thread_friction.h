#pragma once
// How a thread that nobody holds is held by the tissue that it runs through (sutures.h): over a turn of theta it slips
// only where (Euler, Eytelwein)
//
//   T_ahead > T_behind * exp(kThreadFriction * theta)
//
// as a hand feels it that draws one (devices/force/tool_feel.h, with the same coefficient). The end of a thread that
// was laid down untied lies loose on wet skin: needle and thread hold with kFreeEnd_N.
//
// Sutures on artificial skin were measured about a capstan by Zhang, Ren, Zeng and van der Heide, Friction 5 (2017) 87,
// on tissue of pigs by Zhang, Li, Lin and Zhou, Tribol. Lett. 65 (2017): friction falls with load, in wet tissue and by
// a coating. Both numbers are chosen in that light, not measured.
namespace limberg {

inline constexpr double kThreadFriction = 0.3, kFreeEnd_N = 0.02;

}  // namespace limberg
