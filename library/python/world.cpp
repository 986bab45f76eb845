// The patient: acts, steps, and what can be read of it.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "app/assembly/operation.h"
#include "app/assembly/patient_of_scene.h"
#include "app/session/workers_pool.h"
#include "library/python/arrays.h"
#include "library/python/module.h"
#include "sim/base/error.h"
#include "sim/measure/lattice_fields.h"
#include "sim/measure/patient.h"
#include "sim/measure/table.h"
#include "sim/patient/soft_tissue.h"

namespace limberg::python {

namespace {

std::string hex_of(uint64_t v) { return fmt::format("{:016x}", v); }

py::array_t<float> array_of(const Vec3f& v) {
  py::array_t<float> a(3);
  std::copy(v.data(), v.data() + 3, a.mutable_data());
  return a;
}

/// A list of states of the skin, one for each triangle of a surface.
struct PySkinStates {
  std::vector<MembraneState> state;
};

struct PyOperation {
  OperationOutcome outcome;
};

class PyWorld {
 public:
  PyWorld(const PyScene& scene, int workers)
      : scene_(scene),
        workers_(checked(workers)),
        world_(make_world(scene_.scene, workers_)),
        patient_(*world_, scene_.scene.tools.max_depth_mm) {}

  std::string apply(const Command& c) {
    Outcome o;
    {
      py::gil_scoped_release others;
      o = patient_.apply(c);
    }
    if (!o.done) throw RefusedAct{o.reason};
    done_.push_back(c);
    return o.reason;
  }
  StepReport step(std::optional<int> iterations, std::optional<double> tolerance) {
    StepSettings s = step_settings(scene_.scene, false);
    if (iterations) s.max_iterations = *iterations;
    if (tolerance) s.tolerance = *tolerance;
    py::gil_scoped_release others;
    return patient_.step(s);
  }
  StepReport settle(double residual, int most_steps) {
    StepSettings s;
    s.max_iterations = 20, s.tolerance = residual;
    StepReport last;
    for (int i = 0; i < most_steps; ++i) {
      {
        py::gil_scoped_release others;
        last = patient_.step(s);
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (last.residual <= residual && patient_.settled()) break;
    }
    return last;
  }
  PyOperation operate(const Script& script) {
    plan_ = script.header.plan;
    landmarks_.insert(landmarks_.end(), script.header.landmarks.begin(), script.header.landmarks.end());
    OperationSettings set;
    set.on_done = [&](const ScriptLine& l, const std::string&) { done_.push_back(l.command); };
    bool stopped = false;
    set.interrupted = [&] {
      py::gil_scoped_acquire mine;
      return stopped = stopped || PyErr_CheckSignals() != 0;
    };
    PyOperation out;
    {
      py::gil_scoped_release others;
      out.outcome = limberg::operate(patient_, script, set);
    }
    if (stopped) throw py::error_already_set();
    return out;
  }
  std::shared_ptr<Snapshot> snapshot(bool field) const {
    auto s = std::make_shared<Snapshot>();
    world_->fill(*s, field);
    return s;
  }
  LatticeFields lattice() const {
    py::gil_scoped_release others;
    return lattice_fields(skin());
  }
  PySkinStates skin_states() const {
    py::gil_scoped_release others;
    Snapshot s;
    world_->fill(s);
    return {limberg::skin_states(s.topology->view, s.x_mm, *skin().spec().body)};
  }
  py::dict measures(const std::map<std::string, std::pair<double, double>>& landmarks) const {
    MeasureAlso also{plan_, scene_.scene.landmarks, {}};
    also.landmarks.insert(also.landmarks.end(), landmarks_.begin(), landmarks_.end());
    for (const auto& [name, at] : landmarks) also.landmarks.push_back({name, {at.first, at.second}});
    skin();
    const Metrics m = [&] {
      py::gil_scoped_release others;
      return measure_world(*world_, done_, also);
    }();
    py::dict d;
    for (const Measure& x : measure_table())
      if (x.value)
        if (const std::optional<double> v = x.value(m)) {
          if (x.counts)
            d[x.name] = int64_t(*v);
          else
            d[x.name] = *v;
        }
    py::list sutures;
    for (const SutureFigure& s : m.sutures) {
      py::dict k;
      k["id"] = s.id, k["force_N"] = s.force_N, k["gap_mm"] = s.gap_mm, k["peak_N"] = s.peak_N, k["thread"] = s.thread;
      k["at_mm"] = py::make_tuple(s.at_mm[0], s.at_mm[1], s.at_mm[2]);
      sutures.append(k);
    }
    d["sutures"] = sutures;
    py::dict places;
    for (const NamedLandmark& l : m.landmarks) {
      if (l.figure)
        places[l.name.c_str()] = l.figure->displacement_mm;
      else
        places[l.name.c_str()] = py::none();
    }
    d["landmarks"] = places;
    return d;
  }

  const World& world() const { return *world_; }
  const std::vector<Command>& done() const { return done_; }
  const PyScene& scene() const { return scene_; }

 private:
  static int checked(int workers) {
    if (workers < 1 || workers > 256)
      throw InputError("", 0, "workers: " + std::to_string(workers) + " of them; expected 1 to 256");
    return workers;
  }
  const SoftTissue& skin() const {
    if (!world_->skin())
      throw InputError(scene_.scene.path, 0, "the patient has no skin; expected a scene with a [body]");
    return *world_->skin();
  }
  PyScene scene_;
  WorkersPool workers_;
  std::unique_ptr<World> world_;
  WorldPatient patient_;
  std::vector<Command> done_;
  std::optional<PlannedProcedure> plan_;  // of the script that was carried out last
  std::vector<Landmark> landmarks_;       // of scripts
};

void add_snapshot(py::module_& m) {
  py::class_<SutureState>(m, "Stitch", "A stitch as it lies.")
      .def_readonly("id", &SutureState::id, "Its number.")
      .def_readonly("force_N", &SutureState::force_N, "What it pulls with, N.")
      .def_readonly("gap_mm", &SutureState::gap_mm, "What it leaves open between its bites, mm.")
      .def_readonly("thread", &SutureState::thread, "Stitches of one thread have one number; 0: its own.")
      .def_property_readonly(
          "a_mm", [](const SutureState& s) { return array_of(s.a_mm); }, "One bite, (3,) mm.")
      .def_property_readonly(
          "b_mm", [](const SutureState& s) { return array_of(s.b_mm); }, "The other, (3,) mm.");
  py::class_<HookState>(m, "Hook", "A hook as it lies.")
      .def_readonly("id", &HookState::id, "Its number.")
      .def_property_readonly(
          "at_mm", [](const HookState& h) { return array_of(h.at_mm); }, "On the skin, (3,) mm.")
      .def_property_readonly(
          "handle_mm", [](const HookState& h) { return array_of(h.handle_mm); }, "Where it is pulled to, (3,) mm.")
      .def_property_readonly(
          "force_N", [](const HookState& h) { return array_of(h.force_N); }, "Its force on the skin, (3,) N.");
  py::class_<Snapshot, std::shared_ptr<Snapshot>>(
      m, "Snapshot",
      "The patient at one moment, which goes on being that moment: n vertices and m triangles of its surface. Arrays "
      "are "
      "views that keep it alive, read-only; X_mm, triangles and kind are copies.")
      .def_property_readonly(
          "x_mm", [](const std::shared_ptr<Snapshot>& s) { return view_rows<float, 3>(s->x_mm, py::cast(s)); },
          "Where the vertices are, (n, 3) float32, mm.")
      .def_property_readonly(
          "tension", [](const std::shared_ptr<Snapshot>& s) { return view_list(s->field, py::cast(s)); },
          "Largest principal stretch - 1, prestretch included, (n,) float32; (0,) unless it was asked for.")
      .def_property_readonly(
          "X_mm", [](const Snapshot& s) { return copy_rows<double, 3>(s.topology->view.X_mm); },
          "The same vertices at rest, (n, 3) float64, mm.")
      .def_property_readonly(
          "triangles", [](const Snapshot& s) { return copy_rows<int32_t, 3>(s.topology->view.tri); },
          "Corners, counter-clockwise from outside, (m, 3) int32.")
      .def_property_readonly(
          "kind",
          [](const Snapshot& s) {
            py::array_t<uint8_t> out(py::ssize_t(s.topology->view.kind.size()));
            uint8_t* to = out.mutable_data();
            for (const FaceKind k : s.topology->view.kind) *to++ = uint8_t(k);
            return out;
          },
          "(m,) uint8: 0 skin, 1 fixed, 2 free (and bone, face), 3 wall of a cut.")
      .def_readonly("sutures", &Snapshot::sutures, "list of Stitch.")
      .def_readonly("hooks", &Snapshot::hooks, "list of Hook.")
      .def_readonly("step", &Snapshot::step, "Solver steps done.")
      .def_readonly("stage", &Snapshot::stage, "Stages passed, from 0; -1: none.")
      .def_readonly("residual", &Snapshot::residual, "Relative residual of the last step.")
      .def_readonly("distance_mm", &Snapshot::distance_mm, "Estimated distance to equilibrium, mm.")
      .def_readonly("topology_version", &Snapshot::topology_version, "Grows with each cut.")
      .def(
          "to_chart",
          [](const Snapshot& s, const std::array<double, 3>& X) {
            const ChartPoint p = s.topology->to_chart({X[0], X[1], X[2]});
            return py::make_tuple(p.x(), p.y());
          },
          py::arg("X_mm"), "A place at rest on the chart of scripts, (x, y) mm.");
}

template <class T>
auto member(std::vector<T> LatticeFields::*list) {
  return [list](const std::shared_ptr<LatticeFields>& f) { return view_list(*f.*list, py::cast(f)); };
}
auto member(double MembraneState::*value) {
  return [value](const std::shared_ptr<PySkinStates>& s) { return view_member(s->state, value, py::cast(s)); };
}

void add_fields(py::module_& m) {
  py::class_<LatticeFields, std::shared_ptr<LatticeFields>>(
      m, "LatticeFields",
      "The lattice at one moment: n node copies, m cell copies (sim/measure/lattice_fields.h). Arrays are views that "
      "keep "
      "it alive, read-only.")
      .def_property_readonly(
          "X_mm", [](const std::shared_ptr<LatticeFields>& f) { return view_rows<float, 3>(f->X_mm, py::cast(f)); },
          "Nodes at rest, (n, 3) float32, mm.")
      .def_property_readonly(
          "displacement_mm",
          [](const std::shared_ptr<LatticeFields>& f) { return view_rows<float, 3>(f->displacement_mm, py::cast(f)); },
          "x - X, (n, 3) float32, mm.")
      .def_property_readonly(
          "cells", [](const std::shared_ptr<LatticeFields>& f) { return view_rows<int32_t, 8>(f->node, py::cast(f)); },
          "Nodes of each cell, (m, 8) int32; corner k is high in x, y, z where bit 0, 1, 2 of k is set.")
      .def_property_readonly("stretch", member(&LatticeFields::stretch),
                             "Largest principal stretch, prestretch included, (m,) float32.")
      .def_property_readonly(
          "stress_kPa",
          [](const std::shared_ptr<LatticeFields>& f) { return view_rows<float, 6>(f->stress_kPa, py::cast(f)); },
          "Mean Cauchy stress xx, yy, zz, xy, yz, xz, (m, 6) float32, kPa.")
      .def_property_readonly("pressure_kPa", member(&LatticeFields::pressure_kPa), "-tr(stress)/3, (m,) float32, kPa.")
      .def_property_readonly("material", member(&LatticeFields::material),
                             "Index into Scene.layers of the layer at the cell's centre, (m,) int32.")
      .def_property_readonly("fraction", member(&LatticeFields::fraction),
                             "Share of the cell that is tissue of this copy, (m,) float32.")
      .def_property_readonly("piece", member(&LatticeFields::piece), "Connected piece, (m,) int32.");
  py::class_<PySkinStates, std::shared_ptr<PySkinStates>>(
      m, "SkinStates",
      "How each of the surface's m triangles is pulled, as a membrane (sim/measure/skin_strain.h); area 0 where it is "
      "no "
      "skin, and nothing else is meant there. Arrays are views that keep it alive, read-only, (m,) float64.")
      .def_property_readonly("stretch", member(&MembraneState::stretch),
                             "Largest principal stretch, prestretch included.")
      .def_property_readonly("least_stretch", member(&MembraneState::least_stretch), "The other one in the plane.")
      .def_property_readonly("stress_kPa", member(&MembraneState::stress_kPa), "Largest principal Cauchy stress, kPa.")
      .def_property_readonly("least_stress_kPa", member(&MembraneState::least_stress_kPa), "The other one, kPa.")
      .def_property_readonly("angle_deg", member(&MembraneState::angle_deg),
                             "Between the greatest stress and the fibres, 0 to 90; below 0: none.")
      .def_property_readonly("von_mises_kPa", member(&MembraneState::von_mises_kPa), "Of the plane stress, kPa.")
      .def_property_readonly("area_mm2", member(&MembraneState::area_mm2), "At rest, mm2.");
}

}  // namespace

void add_world(py::module_& m) {
  add_snapshot(m);
  add_fields(m);
  py::class_<StepReport>(m, "StepReport", "What came of a solver step.")
      .def_readonly("iterations", &StepReport::iterations, "Of the minimiser.")
      .def_readonly("residual", &StepReport::residual, "Relative residual; single precision reaches about 4e-6.")
      .def_readonly("distance_mm", &StepReport::distance_mm, "Estimated distance to equilibrium, mm.")
      .def_readonly("energy_uJ", &StepReport::energy_uJ, "Elastic energy less what loads have done, uJ.")
      .def_readonly("converged", &StepReport::converged, "The residual is at most the tolerance.")
      .def_readonly("stalled", &StepReport::stalled, "More iterations gain nothing.")
      .def_readonly("min_J", &StepReport::min_J, "Least det F of a cell.")
      .def_readonly("inverted_cells", &StepReport::inverted_cells, "Cells inside out.");
  py::class_<PyOperation>(m, "Operation", "What came of a script that was carried out.")
      .def_property_readonly(
          "residual", [](const PyOperation& o) { return o.outcome.last.residual; }, "Relative residual at the end.")
      .def_property_readonly(
          "iterations", [](const PyOperation& o) { return o.outcome.iterations; },
          "Of the minimiser, in all solver steps.")
      .def_property_readonly(
          "solve_ms", [](const PyOperation& o) { return o.outcome.solve_ms; }, "Wall time of all solver steps, ms.")
      .def_property_readonly(
          "closure",
          [](const PyOperation& o) {
            py::list out;
            for (const ClosureForce& f : o.outcome.closure) {
              py::dict d;
              d["line"] = f.line, d["action"] = f.action, d["sum_N"] = f.sum_N, d["max_N"] = f.max_N;
              d["stitches"] = f.stitches;
              out.append(d);
            }
            return out;
          },
          "Forces of the stitches after each action since the first: list of dicts with line, action, "
          "sum_N, max_N, stitches.")
      .def_property_readonly(
          "stages",
          [](const PyOperation& o) {
            py::list out;
            for (const StageRow& s : o.outcome.stages)
              out.append(py::make_tuple(s.name, std::make_shared<Snapshot>(s.shown)));
            return out;
          },
          "list of (name, Snapshot), in their order.");
  py::class_<PyWorld>(
      m, "World",
      "One patient under the knife. Acts are done or refused, never half; steps lead to equilibrium; the "
      "same acts and steps give the same bits with any number of workers.")
      .def(py::init<const PyScene&, int>(), py::arg("scene"), py::arg("workers") = 1,
           "The patient of a scene, whole. workers: threads, 1 to 256.")
      .def(
          "apply", [](PyWorld& w, const py::handle& told) { return w.apply(command_of(told)); }, py::arg("command"),
          "Carries out a Command, a dict or a line of a script. Returns what is worth knowing, mostly ''. Refused: "
          "with "
          "the reason, and nothing has changed. InputError: it cannot be read.")
      .def("step", &PyWorld::step, py::arg("iterations") = py::none(), py::arg("tolerance") = py::none(),
           "One step, as a session of the scene takes it. iterations: at most so many of the minimiser; tolerance: of "
           "the "
           "relative residual.")
      .def("settle", &PyWorld::settle, py::arg("residual") = 1e-4, py::arg("most_steps") = 300,
           "Steps until the relative residual is that small and every stitch is drawn tight. Returns the last "
           "StepReport.")
      .def("operate", &PyWorld::operate, py::arg("script"),
           "Carries out a Script to equilibrium, exactly as `limberg operate` does: the same bits. InputError with the "
           "line of the action that was refused; what was done before it stays.")
      .def("snapshot", &PyWorld::snapshot, py::arg("tension") = false,
           "Places, stitches and hooks as they are now. tension: its field too (a few ms).")
      .def(
          "lattice_fields", [](const PyWorld& w) { return std::make_shared<LatticeFields>(w.lattice()); },
          "Displacement, stretch, stress, pressure, material of the lattice now.")
      .def(
          "skin_states", [](const PyWorld& w) { return std::make_shared<PySkinStates>(w.skin_states()); },
          "Stretch and stress of each triangle of the surface now.")
      .def("measures", &PyWorld::measures, py::arg("landmarks") = std::map<std::string, std::pair<double, double>>(),
           "Every figure of `limberg measures` that applies, by its name, with sutures (list of dicts) and landmarks "
           "(name -> displacement in mm, None where the skin is gone). landmarks: more of them, name -> (x, y) mm on "
           "the "
           "chart.")
      .def_property_readonly(
          "settled", [](const PyWorld& w) { return w.world().settled(); }, "Every stitch is drawn tight.")
      .def_property_readonly(
          "state_hash", [](const PyWorld& w) { return hex_of(w.world().state_hash()); },
          "Over positions, topology, hooks and sutures, as the program prints it.")
      .def_property_readonly(
          "topology_hash", [](const PyWorld& w) { return hex_of(w.world().topology_hash()); },
          "Over the cuts alone; the same on every machine.")
      .def_property_readonly(
          "refused", [](const PyWorld& w) { return w.world().refused(); }, "Commands refused so far.")
      .def_property_readonly(
          "pieces", [](const PyWorld& w) { return w.world().skin() ? w.world().skin()->pieces() : 0; },
          "Connected pieces of the soft tissue.")
      .def_property_readonly(
          "volume_mm3", [](const PyWorld& w) { return w.world().skin() ? w.world().skin()->volume_mm3() : 0.0; },
          "Exact, of all that remains of the soft tissue at rest, mm3.")
      .def_property_readonly(
          "done",
          [](const PyWorld& w) {
            py::list out;
            for (const Command& c : w.done()) out.append(PyCommand{c});
            return out;
          },
          "list of Command: what was carried out.")
      .def_property_readonly("scene", &PyWorld::scene, "The scene that it is of.");
}

}  // namespace limberg::python
