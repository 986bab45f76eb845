#pragma once
// A fuzz case as plain data: a body, a lattice, and operations that need nothing but each other. Cases are written to
// small JSON files when an invariant breaks; tests/sim/cutting/corpus keeps those that ever did.
#include <string>
#include <vector>

#include "sim/cutting/arrangement/arrangement.h"
#include "sim/lattice/lattice.h"

namespace limberg::fuzz {

/// A closed slab centred on the origin, skin at z = wave(x, y), bottom at -thickness; `columns` squares per side.
struct BodySpec {
  double size_mm = 24, thickness_mm = 8, wave_mm = 0;
  int columns = 6;
  bool loose = false;  // sides are free instead of fixed
};

struct Op {
  enum Kind : uint8_t { cut, excise, undo, redo, replay, fault };
  Kind kind = cut;
  std::string name;  // what the generator meant: incise, cross, deepen, undermine ...

  // cut, fault
  std::vector<Int3> vertex;                         // even half-units
  std::vector<std::pair<int32_t, int32_t>> shared;  // per vertex: (number of a past op, its vertex); -1: none
  std::vector<Tri> tri;
  std::vector<uint8_t> seed_of_tri;
  uint64_t seed = 0;
  double sweep_mm3 = -1;  // >= 0: debris below this goes with the cut

  // excise: the component of this rank by volume, ascending (modulo their number)
  int which = 0;
  // replay: cells of this size
  double cell_mm = 0;
  // fault: where (share of all calls of the same cut), how
  double place = 0;
  bool thrown = false, lasting = false, in_lattice = false;
};

struct Case {
  BodySpec body;
  double cell_mm = 5;
  double lattice_shift = 0.35;  // of a cell, beyond the body's low corner
  int front_levels = 0;         // cells at fronts are divided so often
  std::vector<Op> ops;
  std::string violation;  // what went wrong when it was written
};

TriMesh make_body(const BodySpec& spec);
/// Cubic cells over the body. The planes of a finer lattice with cell_mm / 2 contain those of the coarser one.
LatticeGrid make_lattice(const Case& c, double cell_mm);

std::string to_json(const Case& c);
/// InputError with `file` when the text is not a case.
Case case_from_json(const std::string& text, const std::string& file);
Case read_case(const std::string& file);
void write_case(const Case& c, const std::string& file);

}  // namespace limberg::fuzz
