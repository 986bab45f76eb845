#pragma once
// The law of motion of a simplex mesh, and when it is stable.
//
//   P(t+1) = P(t) + (1 - gamma) (P(t) - P(t-1)) + alpha F_int + beta F_ext
//
// Damped second order (m P'' = -gamma P' + F, discretised). F_int = P~ - P draws a vertex to where its constraint
// wants it over its neighbours: P~ = e1~ A + e2~ B + e3~ C + L(phi~) N, see vertex_shape.h. Wanted metric
// parameters e~ are those of the mesh (1/3 each, or adapted to curvature), for `shape` those of the reference.
//
//   position   the height is kept: vertices only spread in the surface. Holds no shape against other forces
//   tangent    phi~ = 0: to the mean of the neighbours, a membrane; shrinks
//   angle      phi~ = mean of phi over the rigidity neighbourhood:
//              thin-plate like, tends to spheres, hardly shrinks. (The
//              mean takes pi - phi for vertices on the far branch: a flat
//              one whose foot lies outside the circumcircle has phi = pi)
//   curvature  sin(phi~) = r * mean of H over the neighbourhood: the same where vertices are unevenly spaced
//   shape      the reference shape; recovers it up to a similarity,
//              so anchors or other forces have to hold scale and pose
//
// The rigidity neighbourhood of a vertex is all vertices within `rigidity` edges, itself included.
//
// Stability. x' = x + (1 - gamma) (x - x_before) - K x is stable
// if and only if 0 < gamma < 2 and 0 < K < 2 (2 - gamma) for
// every eigenvalue K (von Neumann), hence  alpha lambda_max + beta mu < 2 (2 - gamma),
//                                          with mu the stiffness of F_ext (1 when it
// is target - P) and lambda_max the largest eigenvalue of -dF_int/dx. On even meshes: 2 for position,
// tangent and shape (means over neighbours have eigenvalues in [-1, 1]), 3 for angle and curvature at
// rigidity 1 (3/4 (1 - a)^2 at a = -1) and 2.5 from rigidity 2 on (measured: at most 2.43 on spheres,
// 2026-11-21). Rims of end contours are curves and stay below the same numbers: 8/3, then (1 + 0.22) 2.
#include <limits>
#include <string>
#include <vector>

namespace limberg::simplex {

enum class Constraint : unsigned char { position, tangent, angle, curvature, shape };

struct ZoneLaw {
  Constraint constraint = Constraint::angle;
  double alpha = 0.5;  // weight of the internal force
  double beta = 0.5;   // weight of the external force
  int rigidity = 1;    // edges, 1..64
  bool fixed = false;  // the zone does not move
};

struct Law {
  double gamma = 0.35;            // damping, 0 < gamma < 2
  double external_stiffness = 0;  // mu: of the external force array; 0 when there is none
  // by number of the vertex's zone; numbers beyond the end use the last
  std::vector<ZoneLaw> zone = std::vector<ZoneLaw>(1);
  double metric_gain = 0;  // curvature adaptation of e~, 0: none; useful 0.01 to 0.2
  int metric_every = 10;   // iterations between two adaptations
  double max_step_mm = std::numeric_limits<double>::infinity();  // no vertex moves farther in one iteration
};

/// lambda_max as above.
double lambda_max(Constraint constraint, int rigidity);

enum class Excess { reduce, refuse };
struct Admission {
  Law law;                           // what may be run; alphas reduced where they had to be
  std::vector<std::string> reduced;  // one sentence per zone whose alpha was reduced
  std::string refused;               // why nothing may be run; empty: law is good
  explicit operator bool() const { return refused.empty(); }
};
/// Enforces the bound. Refused are settings that no alpha could make stable (gamma outside 0..2, beta mu too large, a
/// value that is not finite or negative), and with Excess::refuse also those that a smaller alpha would.
Admission admit(Law law, Excess excess = Excess::reduce);

/// What the bound leaves for further stiffness (a cursor that pushes): the least over all zones that move.
double stiffness_left(const Law& law);

}  // namespace limberg::simplex
