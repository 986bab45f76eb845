// Scenes, and materials by themselves.
#include <fmt/format.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "app/assembly/patient_of_scene.h"
#include "library/python/module.h"
#include "sim/base/error.h"
#include "sim/base/quoted.h"
#include "sim/body/skin.h"
#include "sim/commands/procedures/catalogue.h"
#include "sim/commands/procedures/operation.h"
#include "sim/fem/materials/catalogue.h"

namespace limberg::python {

namespace {

py::dict dict_of(const Material& m) {
  py::dict d;
  d["young_kPa"] = m.young_kPa, d["poisson"] = m.poisson, d["density_kg_m3"] = m.density_kg_mm3 * 1e9;
  d["prestretch_along"] = m.prestretch_along, d["prestretch_across"] = m.prestretch_across;
  d["law"] = m.law.name.empty() ? kDefaultLaw : m.law.name, d["tissue"] = m.tissue;
  py::dict constants;
  for (const LawSpec::Constant& c : m.law.constants)
    if (c.value.size() == 1)
      constants[c.key.c_str()] = c.value[0];
    else
      constants[c.key.c_str()] = c.value;
  d["constants"] = constants;
  return d;
}

/// A material for itself: no scene, no mesh.
class PyMaterial {
 public:
  PyMaterial(double young_kPa, double poisson, const std::string& law, const py::dict& constants) {
    material_.young_kPa = young_kPa, material_.poisson = poisson;
    if (law != kDefaultLaw) material_.law.name = law;
    for (const auto& [key, value] : constants)
      material_.law.constants.push_back({key.cast<std::string>(), py::isinstance<py::sequence>(value)
                                                                      ? value.cast<std::vector<double>>()
                                                                      : std::vector<double>{value.cast<double>()}});
    check();
    response_ = layer_response(material_);
  }
  const LayerResponse& response() const { return response_; }

  using Gradients = py::array_t<double, py::array::c_style | py::array::forcecast>;
  py::array_t<double> piola_kPa(const Gradients& F) const {
    py::array_t<double> out(shape_of(F));
    each(F, [&, to = out.mutable_data()](py::ssize_t i, const Mat3& f) {
      const Mat3 P = response_.whole->at(f).P_kPa;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) to[9 * i + 3 * r + c] = P(r, c);
    });
    return out;
  }
  py::array_t<double> energy_kPa(const Gradients& F) const {
    std::vector<py::ssize_t> shape = shape_of(F);
    shape.resize(shape.size() - 2);
    py::array_t<double> out(shape);
    each(F, [&, to = out.mutable_data()](py::ssize_t i, const Mat3& f) { to[i] = response_.whole->at(f).energy_kPa; });
    return out;
  }

 private:
  /// As a scene's reader does: every constant known, given and in its range.
  void check() const {
    const std::string name = material_.law.name.empty() ? kDefaultLaw : material_.law.name;
    const auto laws = shipped_laws();
    const LawCatalogue::Entry* e = laws->find(name);
    if (!e) throw InputError("", 0, "law " + quoted(name, 40) + " is not known; expected one of: " + laws->names());
    for (const LawSpec::Constant& c : material_.law.constants) {
      const auto known = std::find_if(e->constants.begin(), e->constants.end(),
                                      [&](const LawCatalogue::Constant& k) { return k.key == c.key; });
      if (known == e->constants.end())
        throw InputError("", 0, "law " + name + " has no constant " + quoted(c.key, 40) + "; expected one that it has");
      for (const double v : c.value)
        if (!(v >= known->least && v <= known->most) || (known->above && v == known->least))
          throw InputError("", 0,
                           c.key + " is out of range; expected " + (known->above ? "above " : "") +
                               std::to_string(known->least) + " to " + std::to_string(known->most));
      if (c.value.empty() || int(c.value.size()) > known->most_values)
        throw InputError("", 0,
                         c.key + " has " + std::to_string(c.value.size()) + " values; expected 1 to " +
                             std::to_string(known->most_values));
    }
    for (const LawCatalogue::Constant& k : e->constants)
      if (k.required && std::none_of(material_.law.constants.begin(), material_.law.constants.end(),
                                     [&](const LawSpec::Constant& c) { return c.key == k.key; }))
        throw InputError("", 0, "law " + name + " needs " + k.key + "; expected a number");
  }
  static std::vector<py::ssize_t> shape_of(const Gradients& F) {
    if (F.ndim() < 2 || F.shape(F.ndim() - 1) != 3 || F.shape(F.ndim() - 2) != 3)
      throw py::value_error("deformation gradients of another shape; expected (..., 3, 3)");
    return {F.shape(), F.shape() + F.ndim()};
  }
  template <class Visit>
  static void each(const Gradients& F, const Visit& visit) {
    const double* from = F.data();
    for (py::ssize_t i = 0; i < F.size() / 9; ++i, from += 9) {
      Mat3 f;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) f(r, c) = from[3 * r + c];
      visit(i, f);
    }
  }
  Material material_;
  LayerResponse response_;
};

Script planned(const std::string& name, const PyScene& scene, const std::map<std::string, double>& values,
               const std::pair<double, double>& at, double turn_deg, bool mirror) {
  if (!scene.scene.flesh) throw InputError(scene.scene.path, 0, "has no skin; expected a scene with a [body]");
  const Procedure& p = find_procedure(name);
  std::vector<std::string> settings;
  for (const auto& [key, v] : values) settings.push_back(fmt::format("{}={}", key, v));
  const std::vector<double> chosen = procedure_values(p, settings);
  const Figure figure = p.figure(chosen);
  const Skin skin(build_body(scene.scene));
  Placement where;
  where.origin = {at.first, at.second}, where.turn_deg = turn_deg, where.mirrored = mirror;
  Script s;
  s.name = name, s.header.scene = scene.scene.name, s.header.note = name;
  PlannedProcedure plan{p.name, {}, where.origin, turn_deg, mirror};
  for (size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i] != p.parameters[i].value) plan.values.emplace_back(p.parameters[i].name, chosen[i]);
  s.header.plan = plan;
  for (const Command& c : carry_out(figure, OnSkin(skin, where))) s.lines.push_back({int(s.lines.size()) + 2, c});
  return s;
}

}  // namespace

void add_scenes(py::module_& m) {
  py::class_<PyScene>(m, "Scene", "Everything about a patient that is chosen beforehand (app/scene/scene.h).")
      .def_property_readonly(
          "name", [](const PyScene& s) { return s.scene.name; }, "Its name.")
      .def_property_readonly(
          "note", [](const PyScene& s) { return s.scene.note; }, "What it says of itself.")
      .def_property_readonly(
          "path", [](const PyScene& s) { return s.scene.path; }, "Of its file, as given.")
      .def_property_readonly(
          "text", [](const PyScene& s) { return s.scene.text; }, "The whole file.")
      .def_property_readonly(
          "hash", [](const PyScene& s) { return s.scene.hash; }, "Of its text and of the files that it names.")
      .def_property_readonly(
          "has_skin", [](const PyScene& s) { return s.scene.flesh; }, "Whether there is skin.")
      .def_property_readonly(
          "has_head", [](const PyScene& s) { return s.scene.head.has_value(); }, "Whether there are bones.")
      .def_property(
          "cell_mm", [](const PyScene& s) { return s.scene.cell_mm; },
          [](PyScene& s, double v) {
            if (!(v >= 0.05 && v <= 100))
              throw InputError("", 0, "cell_mm is " + std::to_string(v) + "; expected 0.05 to 100 mm");
            s.scene.cell_mm = v;
          },
          "Size of the lattice's cells, mm; may be set before a World is made.")
      .def_property(
          "seed", [](const PyScene& s) { return s.scene.seed; }, [](PyScene& s, uint64_t v) { s.scene.seed = v; },
          "Of all that is drawn by chance; may be set.")
      .def_property_readonly(
          "steps_per_s", [](const PyScene& s) { return s.scene.steps_per_s; }, "Solver steps of a session, 1/s.")
      .def_property_readonly(
          "max_depth_mm", [](const PyScene& s) { return s.scene.tools.max_depth_mm; }, "Deeper cuts are refused, mm.")
      .def_property_readonly(
          "landmarks",
          [](const PyScene& s) {
            py::dict d;
            for (const Landmark& l : s.scene.landmarks) d[l.name.c_str()] = py::make_tuple(l.at.x(), l.at.y());
            return d;
          },
          "name -> (x, y) on the chart, mm.")
      .def_property_readonly(
          "layers",
          [](const PyScene& s) {
            py::list out;
            if (s.scene.flesh)
              for (const Layer& l : s.scene.layers()) {
                py::dict d = dict_of(l.material);
                d["name"] = l.name, d["thickness_mm"] = l.thickness_mm;
                out.append(d);
              }
            return out;
          },
          "From the skin down: list of dicts with name, thickness_mm, young_kPa, poisson, "
          "density_kg_m3, prestretch_along, prestretch_across, law, constants, tissue.")
      .def_property_readonly(
          "regions",
          [](const PyScene& s) {
            py::list out;
            for (const RegionSpec& r : s.scene.regions) {
              py::dict d = dict_of(r.material);
              d["name"] = r.name;
              out.append(d);
            }
            return out;
          },
          "Tissue of its own within the layers (muscle, cartilage, a scar): list of dicts as of layers, without "
          "thickness_mm. Later ones lie over earlier ones.")
      .def("__repr__", [](const PyScene& s) { return "<limberg.Scene " + s.scene.name + ">"; });
  m.def(
      "open_scene",
      [](const std::string& name) {
        return PyScene{open_scene(name), nullptr};
      },
      py::arg("name_or_path"), "A shipped scene by its name, or a scene's file. InputError with file and line.");
  m.def(
      "parse_scene",
      [](const std::string& text, const std::string& path) {
        return PyScene{parse_scene(text, path), nullptr};
      },
      py::arg("text"), py::arg("path") = "scene.toml",
      "A scene of a text; files that it names are looked for beside `path`. InputError.");

  py::class_<PyMaterial>(m, "Material",
                         "A law and its constants by themselves: what resists change of shape. Change of volume is the "
                         "element's own (lambda_kPa), so stresses here are known up to a pressure.")
      .def(py::init<double, double, const std::string&, const py::dict&>(), py::kw_only(), py::arg("young_kPa") = 60.0,
           py::arg("poisson") = 0.45, py::arg("law") = kDefaultLaw, py::arg("constants") = py::dict(),
           "law: one that limberg.laws() lists, with its constants by their keys; the default takes young_kPa. "
           "InputError.")
      .def("piola_kPa", &PyMaterial::piola_kPa, py::arg("F"),
           "First Piola stress dW/dF, kPa, for deformation gradients F[..., i, j] = dx_i/dX_j (float64, (..., 3, 3)), "
           "axes: along the tension lines, across, out. Same shape.")
      .def("energy_kPa", &PyMaterial::energy_kPa, py::arg("F"), "Energy per rest volume, kPa; (...) for (..., 3, 3).")
      .def_property_readonly(
          "mu_kPa", [](const PyMaterial& p) { return p.response().mu_kPa; },
          "Shear modulus at small strain (of the matrix, where there are fibres), kPa.")
      .def_property_readonly(
          "lambda_kPa", [](const PyMaterial& p) { return p.response().lambda_kPa; },
          "Of the element's volume, kPa (sim/fem/model/fem_model.h).");
  m.def(
      "procedures",
      [] {
        py::dict out;
        for (const Procedure& p : procedures()) {
          py::list parameters;
          for (const ProcedureParameter& q : p.parameters) {
            py::dict d;
            d["name"] = q.name, d["help"] = q.help, d["default"] = q.value, d["least"] = q.lo, d["most"] = q.hi;
            parameters.append(d);
          }
          py::dict d;
          d["about"] = p.about, d["parameters"] = parameters;
          out[p.name.c_str()] = d;
        }
        return out;
      },
      "Classical operations by name: dict of dicts with about, and parameters (name, help, default, least, most).");
  m.def("procedure", &planned, py::arg("name"), py::arg("scene"), py::kw_only(),
        py::arg("values") = std::map<std::string, double>(), py::arg("at") = std::pair<double, double>(0, 0),
        py::arg("turn_deg") = 0.0, py::arg("mirror") = false,
        "A classical operation as a Script, laid on the skin of a scene. values: parameter -> number, others as "
        "procedures() says; at: (x, y) mm on the chart; turn_deg: counter-clockwise. InputError: no such procedure or "
        "parameter, out of range, or off the skin.");
  m.def(
      "laws",
      [] {
        py::dict out;
        for (const LawCatalogue::Entry& e : shipped_laws()->entries()) {
          py::list constants;
          for (const LawCatalogue::Constant& c : e.constants) {
            py::dict d;
            d["key"] = c.key, d["least"] = c.least, d["most"] = c.most, d["required"] = c.required;
            d["default"] = c.otherwise, d["most_values"] = c.most_values;
            constants.append(d);
          }
          py::dict d;
          d["about"] = e.about, d["constants"] = constants;
          out[e.name.c_str()] = d;
        }
        return out;
      },
      "Laws by name: dict of dicts with about, and constants (key, least, most, required, default, most_values).");
}

}  // namespace limberg::python
