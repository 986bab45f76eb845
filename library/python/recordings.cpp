// Recordings: the hands as they were received, read and written.
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "app/assembly/bundle.h"
#include "app/assembly/patient_of_scene.h"
#include "app/program/version.h"
#include "devices/recording.h"
#include "library/python/module.h"
#include "sim/base/error.h"

namespace limberg::python {

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Bits = py::array_t<uint32_t, py::array::c_style | py::array::forcecast>;

const char* tool_name(Tool t) {
  static const char* const kNames[] = {"none",
                                       "scalpel",
                                       "undermine",
                                       "excise",
                                       "hook",
                                       "suture",
                                       "suture_row",
                                       "scissors",
                                       "saw",
                                       "grab",
                                       "suture_buried",
                                       "suture_corner",
                                       "suture_running",
                                       "hook_out",
                                       "marker",
                                       "swab",
                                       "suture_bites",
                                       "suture_knot",
                                       "suture_row_buried",
                                       "suture_deep",
                                       "scalpel_through"};
  static_assert(std::size(kNames) == size_t(kLastTool) + 1);
  return kNames[std::clamp(int(t), 0, int(kLastTool))];
}

/// Columns of the readings of one kind.
struct Columns {
  std::vector<double> t_s, place, quat;
  std::vector<uint32_t> buttons;
  std::vector<int32_t> of;
  void add(int64_t t_ns, const Vec3& at, const std::array<double, 4>& q, uint32_t pressed, int32_t who) {
    t_s.push_back(double(t_ns) * 1e-9), place.insert(place.end(), {at.x(), at.y(), at.z()});
    quat.insert(quat.end(), q.begin(), q.end()), buttons.push_back(pressed), of.push_back(who);
  }
  py::dict dict(const char* place_name, const char* of_name) const {
    const auto n = py::ssize_t(t_s.size());
    py::dict d;
    d["t_s"] = py::array_t<double>(n, t_s.data());
    d[place_name] = py::array_t<double>({n, py::ssize_t(3)}, place.data());
    d["quat"] = py::array_t<double>({n, py::ssize_t(4)}, quat.data());
    d["buttons"] = py::array_t<uint32_t>(n, buttons.data());
    d[of_name] = py::array_t<int32_t>(n, of.data());
    return d;
  }
};

py::dict stylus_of(const Recording& r) {
  Columns c;
  for (const Sample& s : r.samples)
    if (const auto* p = std::get_if<StylusSample>(&s)) c.add(p->t_ns, p->tip_mm, p->quat, p->buttons, p->device_id);
  return c.dict("tip_mm", "device");
}
py::dict tracker_of(const Recording& r) {
  Columns c;
  for (const Sample& s : r.samples)
    if (const auto* p = std::get_if<TrackerSample>(&s)) c.add(p->t_ns, p->pos_mm, p->quat, p->buttons, p->station);
  return c.dict("position_mm", "station");
}

py::list controls_of(const Recording& r) {
  py::list out;
  for (const Sample& s : r.samples) {
    const auto* c = std::get_if<ControlSample>(&s);
    if (!c) continue;
    py::dict d;
    d["t_s"] = double(c->t_ns) * 1e-9, d["kind"] = c->kind, d["tool"] = tool_name(c->tool), d["text"] = c->text.str();
    d["value"] = py::make_tuple(c->value[0], c->value[1], c->value[2], c->value[3]);
    out.append(d);
  }
  return out;
}
py::list commands_of(const Recording& r) {
  py::list out;
  for (const Sample& s : r.samples)
    if (const auto* c = std::get_if<CommandSample>(&s); c && c->command)
      out.append(py::make_tuple(double(c->t_ns) * 1e-9, PyCommand{*c->command}));
  return out;
}

py::dict session_of(const Recording& r) {
  py::dict d;
  if (!r.session) return d;
  const SessionInfo& s = *r.session;
  d["format_version"] = s.format_version, d["program"] = s.program, d["scene_name"] = s.scene_name;
  d["scene_hash"] = s.scene_hash, d["tick_ns"] = s.tick_ns, d["ticks_per_solver_step"] = s.ticks_per_solver_step;
  d["utc_start_ns"] = s.utc_start_ns;
  return d;
}

struct PyRecording {
  Recording recording;
  std::string path;
};

int64_t time_ns(double t_s) {
  if (!(t_s >= 0 && t_s * 1e3 < double(kMostTicks)))
    throw InputError("", 0, "a time of " + std::to_string(t_s) + " s; expected 0 s to a day");
  return int64_t(std::llround(t_s * 1e9));
}

/// In the order of their times; a stylus at 120 Hz, commands when they were made.
void write_recording(const std::string& path, const PyScene& scene, const std::optional<Numbers>& t_s,
                     const std::optional<Numbers>& tip_mm, const std::optional<Numbers>& quat,
                     const std::optional<Bits>& buttons, const std::vector<std::pair<double, py::object>>& commands,
                     bool replace) {
  std::vector<Sample> samples;
  if (t_s || tip_mm) {
    const py::ssize_t n = t_s ? t_s->size() : 0;
    const auto rows = [&](const Numbers& a, py::ssize_t k) {
      return a.ndim() == 2 && a.shape(0) == n && a.shape(1) == k;
    };
    if (!t_s || !tip_mm || t_s->ndim() != 1 || !rows(*tip_mm, 3))
      throw py::value_error("t_s and tip_mm of other shapes; expected (n,) and (n, 3)");
    if (quat && !rows(*quat, 4)) throw py::value_error("quat of another shape; expected (n, 4)");
    if (buttons && (buttons->ndim() != 1 || buttons->shape(0) != n))
      throw py::value_error("buttons of another shape; expected (n,)");
    for (py::ssize_t i = 0; i < n; ++i) {
      StylusSample s;
      s.t_ns = time_ns(t_s->at(i)), s.seq = int64_t(i);
      s.tip_mm = {tip_mm->at(i, 0), tip_mm->at(i, 1), tip_mm->at(i, 2)};
      if (!s.tip_mm.allFinite()) throw InputError("", 0, "tip_mm is not finite; expected places in mm");
      if (quat) {
        const Eigen::Vector4d q(quat->at(i, 0), quat->at(i, 1), quat->at(i, 2), quat->at(i, 3));
        if (!(std::abs(q.norm() - 1) < 1e-3)) throw InputError("", 0, "quat is not of length 1; expected w, x, y, z");
        s.quat = {q[0], q[1], q[2], q[3]};
      }
      if (buttons) s.buttons = buttons->at(i);
      samples.push_back(s);
    }
  }
  int64_t number = 0;
  for (const auto& [at_s, told] : commands) {
    CommandSample c = command_sample(command_of(told));
    c.t_ns = time_ns(at_s), c.seq = number++;
    samples.push_back(c);
  }
  if (samples.empty()) throw InputError(path, 0, "nothing to be recorded; expected readings of a stylus, or commands");
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return time_of(a) < time_of(b); });
  const Calibration calibration;
  SessionInfo info;
  info.program = program_name().substr(0, 95), info.scene_name = scene.scene.name.substr(0, 63);
  info.scene_hash = scene.scene.hash, info.calibration_hash = calibration_hash(calibration);
  info.seeds = {scene.scene.seed, 0, 0, 0};
  info.ticks_per_solver_step = ticks_per_solver_step(scene.scene);
  RecordingWriter out;
  out.open(path, info, bundle(scene.scene, calibration), replace);
  for (const Sample& s : samples) out.on_sample(s);
  // No end: what the patient's state was then is not known here. A replay goes on until the samples have ended.
  if (!out.cut_short()) throw InputError(path, 0, out.error() + "; expected room and permission");
}

}  // namespace

void add_recordings(py::module_& m) {
  py::class_<PyRecording>(m, "Recording",
                          "A session as it was recorded (devices/recording.h): every sample as received.")
      .def_property_readonly(
          "path", [](const PyRecording& r) { return r.path; }, "Its file.")
      .def_property_readonly(
          "session", [](const PyRecording& r) { return session_of(r.recording); },
          "What made it: dict with program, scene_name, scene_hash, tick_ns, ticks_per_solver_step, "
          "utc_start_ns, format_version; {} where it is lost.")
      .def(
          "stylus", [](const PyRecording& r) { return stylus_of(r.recording); },
          "Readings of styluses in the order in which they came: dict of t_s (n,) s, tip_mm (n, 3) mm in the room, "
          "quat "
          "(n, 4) w x y z (the shaft is +z, from tip to hand), buttons (n,) uint32 (bit 0: the tool is engaged), "
          "device "
          "(n,) int32.")
      .def(
          "tracker", [](const PyRecording& r) { return tracker_of(r.recording); },
          "Readings of stations in the tracker's own frame: dict of t_s, position_mm (n, 3), quat (n, 4), buttons, "
          "station (n,) int32.")
      .def_property_readonly(
          "controls", [](const PyRecording& r) { return controls_of(r.recording); },
          "Choices away from the hand: list of dicts with t_s, kind, tool, text, value "
          "(devices/sample.h).")
      .def_property_readonly(
          "commands", [](const PyRecording& r) { return commands_of(r.recording); },
          "Commands of panels and programs: list of (t_s, Command).")
      .def_property_readonly(
          "checkpoints",
          [](const PyRecording& r) {
            py::list out;
            for (const Checkpoint& c : r.recording.checkpoints)
              out.append(py::make_tuple(double(c.tick) * 1e-3, c.hash));
            return out;
          },
          "Hashes of the state: list of (t_s, hash).")
      .def_property_readonly(
          "damaged", [](const PyRecording& r) { return r.recording.damage.total(); },
          "Events that were lost; 0: it is whole.")
      .def_property_readonly(
          "ended", [](const PyRecording& r) { return r.recording.end.has_value(); },
          "False: the session was cut short, or made by write_recording.")
      .def(
          "scene",
          [](const PyRecording& r) {
            Unbundled u = unbundle_scene(r.recording, r.path);
            return PyScene{std::move(u.scene), std::move(u.files)};
          },
          "The scene that it was made with. InputError: it does not hold it whole.");
  m.def(
      "read_recording",
      [](const std::string& path) {
        py::gil_scoped_release others;
        return PyRecording{read_recording(path), path};
      },
      py::arg("path"),
      "Reads a recording (.lcm). Damage is skipped and counted. InputError: it cannot be read, or holds nothing "
      "valid.");
  m.def("write_recording", &write_recording, py::arg("path"), py::arg("scene"), py::kw_only(),
        py::arg("t_s") = py::none(), py::arg("tip_mm") = py::none(), py::arg("quat") = py::none(),
        py::arg("buttons") = py::none(), py::arg("commands") = std::vector<std::pair<double, py::object>>(),
        py::arg("replace") = false,
        "Writes a recording that `limberg replay` carries out: readings of a stylus (t_s (n,) s, tip_mm (n, 3) mm, "
        "quat (n, "
        "4) w x y z, buttons (n,)), and commands, list of (t_s, Command, dict or line), by their times. InputError: "
        "the file "
        "exists (unless replace) or cannot be written, nothing is given, a value is none.");
}

}  // namespace limberg::python
