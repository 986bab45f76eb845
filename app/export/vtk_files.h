#pragma once
// The lattice and the skin as VTK's XML files, which ParaView opens: values in binary, little endian, after the XML
// (appended, raw). mm, kPa. VTK itself is not linked: the format is a page of XML (VTK File Formats, "XML File
// Formats"), and tests/app/export/read_vtk.py reads the files with VTK.
//
//   vtu   each copy of each cell of the lattice as a hexahedron: displacement at its corners; stretch, stress (xx yy zz
//         xy yz xz), pressure, material, fraction, piece (sim/measure/lattice_fields.h)
//   vtp   the surface's triangles, their kind and organ; displacement at the corners; of skin stretch, stress, rest
//   area pvd   which file belongs to which time
// Both name in their field data the moment, its time and the patient's hash.
#include <span>
#include <string>
#include <vector>

#include "sim/measure/lattice_fields.h"
#include "sim/measure/skin_strain.h"
#include "sim/patient/snapshot.h"

namespace limberg {

/// What is said of the moment itself.
struct VtkMoment {
  std::string name, state_hash, layers;  // layers: "0 skin, 1 fat": what `material` means
  double t_s = 0;
};

std::string vtu_bytes(const LatticeFields& fields, const VtkMoment& moment);
/// `states`: of skin_states(), or empty where there is no skin.
std::string vtp_bytes(const Snapshot& snapshot, std::span<const MembraneState> states, const VtkMoment& moment);

struct PvdEntry {
  double t_s = 0;
  std::string file;  // beside the PVD, or below
};
std::string pvd_text(std::span<const PvdEntry> entries);

}  // namespace limberg
