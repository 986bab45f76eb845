#include "sim/testing/stl.h"

#include <bit>

#include "sim/base/whole_file.h"
#include "sim/skull/bone/surface.h"

namespace limberg::bone {
namespace {

void put(std::string& s, uint32_t v, int bytes) {
  for (int i = 0; i < bytes; ++i) s += char((v >> (8 * i)) & 0xff);
}
void put(std::string& s, const Vec3& x) {
  for (int k = 0; k < 3; ++k) put(s, std::bit_cast<uint32_t>(float(x[k])), 4);
}

}  // namespace

std::string to_stl(const simplex::Mesh& m, int32_t vertex, const Eigen::Isometry3d& pose) {
  if (!m.alive(vertex)) throw InputError("", 0, "there is no vertex " + std::to_string(vertex));
  const BoneSurface b = bone_surface(m, component_of(m, vertex));
  std::string s = "limberg bone fragment, mm";
  s.resize(80, ' ');
  put(s, uint32_t(b.tri.size()), 4);
  for (size_t t = 0; t < b.tri.size(); ++t) {
    put(s, Vec3(pose.linear() * b.normal(int32_t(t))));
    for (int32_t v : b.tri[t]) put(s, Vec3(pose * b.X_mm[size_t(v)]));
    put(s, 0, 2);
  }
  return s;
}

void save_stl(const std::string& bytes, const std::string& path) { write_whole_file(path, bytes); }

}  // namespace limberg::bone
