#include "app/export/vtk_files.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

namespace limberg {

namespace {

static_assert(std::endian::native == std::endian::little, "VTK files are written in the machine's own order");

std::string xml_escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else if (uint8_t(c) >= 32 || c == '\t')
      out += c;
    else
      out += ' ';
  }
  return out;
}

/// The XML of a file on the way, and what comes after it.
class VtkFile {
 public:
  explicit VtkFile(const char* kind) : kind_(kind) {
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<{}>\n",
        kind, kind);
  }
  void line(const std::string& text) { xml_ += text + "\n"; }
  template <class T>
  void array(const char* name, const char* type, int components, const std::vector<T>& values, const char* more = "") {
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, more, after_.size());
    const uint64_t bytes = values.size() * sizeof(T);
    after_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    after_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }
  void moment(const VtkMoment& m) {
    line("<FieldData>");
    for (const auto& [name, text] :
         {std::pair("moment", m.name), std::pair("state_hash", m.state_hash), std::pair("layers", m.layers)}) {
      if (text.empty()) continue;
      std::string numbers;  // VTK has texts as their bytes, ended by a zero
      for (const char c : text) numbers += std::to_string(int(uint8_t(c))) + " ";
      line(fmt::format("<Array type=\"String\" Name=\"{}\" NumberOfTuples=\"1\" format=\"ascii\">{}0</Array>", name,
                       numbers));
    }
    line(fmt::format(
        "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>", m.t_s));
    line("</FieldData>");
  }
  std::string bytes() && {
    return xml_ + fmt::format("</{}>\n<AppendedData encoding=\"raw\">\n_", kind_) + after_ +
           "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  const char* kind_;
  std::string xml_, after_;
};

std::vector<float> flat(std::span<const Vec3f> x) {
  std::vector<float> out;
  out.reserve(3 * x.size());
  for (const Vec3f& v : x) out.insert(out.end(), {v.x(), v.y(), v.z()});
  return out;
}

std::vector<int32_t> multiples(size_t n, int32_t of) {
  std::vector<int32_t> out(n);
  for (size_t i = 0; i < n; ++i) out[i] = of * int32_t(i + 1);
  return out;
}

}  // namespace

std::string vtu_bytes(const LatticeFields& f, const VtkMoment& moment) {
  VtkFile out("UnstructuredGrid");
  out.moment(moment);
  out.line(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">", f.X_mm.size(), f.node.size()));
  std::vector<Vec3f> x(f.X_mm);
  for (size_t i = 0; i < x.size(); ++i) x[i] += f.displacement_mm[i];
  out.line("<PointData Vectors=\"displacement_mm\">");
  out.array("displacement_mm", "Float32", 3, flat(f.displacement_mm));
  out.line("</PointData>\n<CellData Scalars=\"stretch\" Tensors=\"stress_kPa\">");
  out.array("stretch", "Float32", 1, f.stretch);
  std::vector<float> stress;
  for (const auto& s : f.stress_kPa) stress.insert(stress.end(), s.begin(), s.end());
  out.array("stress_kPa", "Float32", 6, stress,
            " ComponentName0=\"XX\" ComponentName1=\"YY\" ComponentName2=\"ZZ\" ComponentName3=\"XY\" "
            "ComponentName4=\"YZ\" ComponentName5=\"XZ\"");
  out.array("pressure_kPa", "Float32", 1, f.pressure_kPa);
  out.array("material", "Int32", 1, f.material);
  out.array("fraction", "Float32", 1, f.fraction);
  out.array("piece", "Int32", 1, f.piece);
  out.line("</CellData>\n<Points>");
  out.array("Points", "Float32", 3, flat(x));
  out.line("</Points>\n<Cells>");
  constexpr int kOrder[8] = {0, 1, 3, 2, 4, 5, 7, 6};  // VTK goes round each end
  std::vector<int32_t> corners;
  corners.reserve(8 * f.node.size());
  for (const auto& cell : f.node)
    for (const int k : kOrder) corners.push_back(cell[size_t(k)]);
  out.array("connectivity", "Int32", 1, corners);
  out.array("offsets", "Int32", 1, multiples(f.node.size(), 8));
  out.array("types", "UInt8", 1, std::vector<uint8_t>(f.node.size(), 12));  // VTK_HEXAHEDRON
  out.line("</Cells>\n</Piece>");
  return std::move(out).bytes();
}

std::string vtp_bytes(const Snapshot& s, std::span<const MembraneState> states, const VtkMoment& moment) {
  const SurfaceView& view = s.topology->view;
  VtkFile out("PolyData");
  out.moment(moment);
  out.line(fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfPolys=\"{}\">", s.x_mm.size(), view.tri.size()));
  std::vector<Vec3f> moved(s.x_mm);
  for (size_t v = 0; v < moved.size(); ++v) moved[v] -= view.X_mm[v].cast<float>();
  out.line("<PointData Vectors=\"displacement_mm\">");
  out.array("displacement_mm", "Float32", 3, flat(moved));
  out.line("</PointData>\n<CellData>");
  std::vector<uint8_t> kind, organ;
  for (size_t t = 0; t < view.tri.size(); ++t)
    kind.push_back(uint8_t(view.kind[t])), organ.push_back(uint8_t(s.topology->organ_of(t)));
  out.array("kind", "UInt8", 1, kind);    // 0 skin, 1 fixed, 2 free, 3 wall of a cut
  out.array("organ", "UInt8", 1, organ);  // 0 flesh, 1 face, 2 bone, 3 cut bone
  if (states.size() == view.tri.size()) {
    std::vector<float> stretch, least, stress, least_stress, area;
    for (const MembraneState& m : states) {
      stretch.push_back(float(m.stretch)), least.push_back(float(m.least_stretch));
      stress.push_back(float(m.stress_kPa)), least_stress.push_back(float(m.least_stress_kPa));
      area.push_back(float(m.area_mm2));
    }
    out.array("stretch", "Float32", 1, stretch);
    out.array("least_stretch", "Float32", 1, least);
    out.array("stress_kPa", "Float32", 1, stress);
    out.array("least_stress_kPa", "Float32", 1, least_stress);
    out.array("rest_area_mm2", "Float32", 1, area);  // 0 where it is no skin, and nothing of the above is meant
  }
  out.line("</CellData>\n<Points>");
  out.array("Points", "Float32", 3, flat(s.x_mm));
  out.line("</Points>\n<Polys>");
  std::vector<int32_t> corners;
  corners.reserve(3 * view.tri.size());
  for (size_t t = 0; t < view.tri.size(); ++t)
    for (const int32_t v : view.tri[t]) corners.push_back(v);
  out.array("connectivity", "Int32", 1, corners);
  out.array("offsets", "Int32", 1, multiples(view.tri.size(), 3));
  out.line("</Polys>\n</Piece>");
  return std::move(out).bytes();
}

std::string pvd_text(std::span<const PvdEntry> entries) {
  std::string out = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const PvdEntry& e : entries)
    out += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", e.t_s, xml_escaped(e.file));
  return out + "</Collection>\n</VTKFile>\n";
}

}  // namespace limberg
