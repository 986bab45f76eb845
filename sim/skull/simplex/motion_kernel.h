#pragma once
// The hot loops of the motion: geometry, target, update, for eight vertices at a time.
//
// Plain arrays in, plain arrays out. A vertex goes through the same operations wherever it stands in its group of
// eight, so results do not depend on how the range is cut. All pointers may be unaligned; x, before, ext and push hold
// three doubles per vertex, nbr three numbers (-1: the slot is free), metric two.
#include <cstddef>
#include <cstdint>

namespace limberg::simplex {

/// Reference shape in the form that the kernel uses.
struct KernelShape {
  double e1 = 0, e2 = 0, sin_phi = 0, cos_phi = 1, height = 0;
  double branch = 1;  // 1: root near the plane, -1: far root, 0: the height
};
struct KernelZone {
  int32_t constraint = 0;  // Constraint
  int32_t rigidity = 1;
  double alpha = 0, beta = 0;
};

struct KernelView {
  const double* x = nullptr;
  const int32_t* nbr = nullptr;
  const uint16_t* zone = nullptr;
  const uint8_t* flags = nullptr;
  const double* metric = nullptr;
  const KernelShape* shape = nullptr;  // needed when a zone has the constraint shape
  const KernelZone* law = nullptr;
  int32_t zones = 1;
  const double* phi = nullptr;         // of every vertex; needed by angle
  const double* H = nullptr;           // needed by curvature
  const size_t* near_first = nullptr;  // rigidity >= 2: neighbourhood of v is near[near_first[v] .. near_first[v + 1])
  const int32_t* near = nullptr;
  const double* ext = nullptr;   // may be null: external force
  const double* push = nullptr;  // may be null: added as it is
  double keep = 0;               // 1 - gamma
  double max_step_mm = 0;
  bool large = false;  // the positions do not fit the near caches
};

/// Simplex angle (pi less it on the far branch) and mean curvature of vertices [begin, end); phi or H may be null.
void kernel_curvature(const KernelView& v, size_t begin, size_t end, double* phi, double* H);

struct KernelSums {
  double max_move2 = 0, sum_move2 = 0;
};
/// before[i] := x + keep (x - before) + alpha F_int + beta ext + push for vertices of [begin, end).
KernelSums kernel_step(const KernelView& v, size_t begin, size_t end, double* before);
/// force[i] := F_int.
void kernel_force(const KernelView& v, size_t begin, size_t end, double* force);

}  // namespace limberg::simplex
