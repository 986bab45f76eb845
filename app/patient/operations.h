#pragma once
// Operations on the bones of a head, written from its landmarks and meshes: what stands beside a patient's scene, and
// what `limberg procedure` lays on any scene with a head.
//
//   genioplasty            the chin, cut off below the front teeth, 6 mm forwards along its cut
//   le_fort_1              the maxilla, cut level above its roots and upright through the pterygoid region, 6 mm
//                          forwards
//   le_fort_3              the midface: level through the suture between nose and forehead, the orbits and their outer
//                          rims, upright through arches and pterygoid region, 8 mm forwards. One step of two planes:
//                          the floors of the orbits go forwards whole, their inner walls are cut level and not along
//                          the lacrimal groove, the arch upright and not along its suture
//   sagittal_split         both sides of the mandible, split between level, middle and upright cuts; the tooth-bearing
//                          part 6 mm forwards
//   autorotation           the mandible opened by 10 degrees about the line through the condyles
//   fronto_orbital         the forehead with the upper rims of the orbits, 8 mm forwards
//
// Every cut is tried on the bones before it is written: a plan that the saw refuses, or that frees something else than
// it should, is tried again a little higher, lower, farther forwards or back. What cannot be made is left out, and why
// is said.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/workers.h"
#include "sim/commands/script.h"
#include "sim/imaging/anatomy/anatomy.h"
#include "sim/skull/simplex/mesh.h"

namespace limberg {

/// In the frame of the head: x right, y forwards, z up, origin between the porions. Bones are named cranium and
/// mandible, others as they like.
struct OperationGround {
  std::vector<std::pair<std::string, simplex::Mesh>> bones;
  std::vector<FoundLandmark> landmarks;
};

struct PlannedOperation {
  std::string name;   // of its file, without .jsonl
  std::string title;  // what it is, a line
  Script script;      // no lines: it could not be made
  std::string why;    // then the reason; otherwise empty
  bool made() const { return why.empty(); }
};

/// What can be planned, with the one number that it takes: how far the piece goes, or is turned.
struct KnownOperation {
  const char *name, *about, *parameter;
  double usual, least, most;
};
std::vector<KnownOperation> known_operations();  // in the order above

/// One of them. Throws InputError: no such name.
PlannedOperation plan_operation(const OperationGround& ground, std::string_view name, double amount, Workers& workers);

/// All of them by their usual amounts, for a scene called patient. Some seconds: each tries its cuts on a copy of the
/// bones.
std::vector<PlannedOperation> plan_operations(const OperationGround& ground, Workers& workers);

}  // namespace limberg
