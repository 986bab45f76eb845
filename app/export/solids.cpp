#include "app/export/solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace limberg {

namespace {

void put_bytes(std::string& s, uint32_t v, int bytes) {
  for (int i = 0; i < bytes; ++i) s += char((v >> (8 * i)) & 0xff);
}
void put_floats(std::string& s, const Vec3& x) {
  for (int k = 0; k < 3; ++k) put_bytes(s, std::bit_cast<uint32_t>(float(x[k])), 4);
}
/// A header is a line.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) > 0x7e) c = ' ';
  return text;
}

double six_volumes(const Surface& s, const Tri& t) {
  return s.x_mm[size_t(t[0])].dot(s.x_mm[size_t(t[1])].cross(s.x_mm[size_t(t[2])]));
}

}  // namespace

SolidFigures solid_figures(const Surface& s) {
  SolidFigures out;
  std::vector<uint64_t> edge;
  edge.reserve(3 * s.tri.size());
  for (const Tri& t : s.tri) {
    out.volume_mm3 += six_volumes(s, t) / 6;
    for (size_t k = 0; k < 3; ++k) edge.push_back(uint64_t(uint32_t(t[k])) << 32 | uint32_t(t[(k + 1) % 3]));
  }
  std::sort(edge.begin(), edge.end());
  const auto times = [&](uint64_t e) {
    const auto r = std::equal_range(edge.begin(), edge.end(), e);
    return r.second - r.first;
  };
  for (const uint64_t e : edge) out.open_edges += times(e) != 1 || times(e << 32 | e >> 32) != 1;
  return out;
}

std::vector<Surface> parts_of(const Surface& s, double least_mm3) {
  std::vector<int32_t> root(s.x_mm.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int32_t v) {
    while (root[size_t(v)] != v) v = root[size_t(v)] = root[size_t(root[size_t(v)])];
    return v;
  };
  for (const Tri& t : s.tri)
    for (size_t k = 1; k < 3; ++k) root[size_t(find(t[k]))] = find(t[0]);
  std::vector<double> six(s.x_mm.size(), 0);
  for (const Tri& t : s.tri) six[size_t(find(t[0]))] += six_volumes(s, t);
  std::vector<int32_t> kept;
  for (size_t v = 0; v < six.size(); ++v)
    if (six[v] >= 6 * least_mm3 && six[v] > 0) kept.push_back(int32_t(v));
  std::stable_sort(kept.begin(), kept.end(), [&](int32_t a, int32_t b) { return six[size_t(a)] > six[size_t(b)]; });
  std::vector<Surface> out;
  for (const int32_t r : kept) {
    Surface part;
    part.x_mm = s.x_mm;
    for (const Tri& t : s.tri)
      if (find(t[0]) == r) part.tri.push_back(t);
    out.push_back(compacted(part));
  }
  return out;
}

void move(Surface& s, const Eigen::Isometry3d& by) {
  for (Vec3& x : s.x_mm) x = by * x;
}

std::string stl_bytes(const Surface& s, const std::string& title) {
  std::string out = one_line(title);
  out.resize(80, ' ');
  if (out.starts_with("solid")) out[0] = 'S';  // that word begins a file of text
  put_bytes(out, uint32_t(s.tri.size()), 4);
  out.reserve(84 + 50 * s.tri.size());
  for (const Tri& t : s.tri) {
    const Vec3 &a = s.x_mm[size_t(t[0])], &b = s.x_mm[size_t(t[1])], &c = s.x_mm[size_t(t[2])];
    const Vec3 n = (b - a).cross(c - a);
    put_floats(out, n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero()));
    put_floats(out, a), put_floats(out, b), put_floats(out, c);
    put_bytes(out, 0, 2);
  }
  return out;
}

std::string obj_text(const Surface& s) {
  std::string out = "# Lengths in mm.\n";
  for (const Vec3& x : s.x_mm) out += fmt::format("v {:.5f} {:.5f} {:.5f}\n", x.x(), x.y(), x.z());
  for (const Tri& t : s.tri) out += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return out;
}

std::string ply_bytes(const Surface& s, const std::string& title) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment {}\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      one_line(title), s.x_mm.size(), s.tri.size());
  for (const Vec3& x : s.x_mm) put_floats(out, x);
  for (const Tri& t : s.tri) {
    out += char(3);
    for (const int32_t v : t) put_bytes(out, uint32_t(v), 4);
  }
  return out;
}

}  // namespace limberg
