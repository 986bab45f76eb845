// Commands and scripts.
#include <pybind11/stl.h>

#include "library/python/module.h"
#include "sim/base/error.h"
#include "sim/commands/actions.h"
#include "sim/commands/words.h"

namespace limberg::python {

namespace {

py::object json_module() { return py::module_::import("json"); }

py::dict fields_of(const PyCommand& c) { return json_module().attr("loads")(c.line()); }

py::list actions_list() {
  py::list out;
  for (const ActionLine& a : action_lines()) {
    py::list fields;
    for (const ActionField& f : a.fields) {
      py::dict d;
      d["key"] = f.field.key, d["kind"] = f.kind, d["unit"] = f.unit, d["limits"] = f.limits;
      d["default"] = f.otherwise, d["help"] = f.field.help, d["required"] = f.field.stands == Stands::always;
      fields.append(d);
    }
    py::dict d;
    d["name"] = a.name, d["form"] = a.form, d["of_head"] = a.of_head, d["help"] = a.help, d["example"] = a.example;
    d["fields"] = fields;
    out.append(d);
  }
  return out;
}

Script script_from(const py::iterable& commands, const std::string& scene, const std::string& note) {
  Script s;
  s.name = "script";
  s.header.scene = scene, s.header.note = note;
  for (const py::handle& c : commands) s.lines.push_back({int(s.lines.size()) + 2, command_of(c)});
  return s;
}

}  // namespace

Command command_of(const py::handle& told) {
  if (py::isinstance<PyCommand>(told)) return told.cast<PyCommand>().command;
  if (py::isinstance<py::str>(told)) return parse_command(told.cast<std::string>(), "command", 0);
  if (py::isinstance<py::dict>(told)) {
    // NumPy's numbers and arrays as Python's own.
    const py::object plain = py::module_::import("limberg._plain").attr("plain")(told);
    return parse_command(json_module().attr("dumps")(plain).cast<std::string>(), "command", 0);
  }
  throw py::type_error("expected a limberg.Command, a dict with \"action\", or a line of a script");
}

void add_commands(py::module_& m) {
  py::class_<PyCommand>(
      m, "Command",
      "One act of a surgeon, as a line of a script states it: places on the chart in mm, no mesh. "
      "limberg.incise(...) and its like make them; limberg.actions() lists all with units and limits.")
      .def(py::init([](const py::handle& told) { return PyCommand{command_of(told)}; }), py::arg("told"),
           "Of a dict {'action': 'incise', 'path': [[0, 0], [10, 0]], ...} or a line of a script. InputError.")
      .def_property_readonly(
          "action", [](const PyCommand& c) { return action_name(c.command); }, "The word after \"action\".")
      .def_property_readonly("fields", &fields_of, "All fields, \"action\" too, as a dict.")
      .def_property_readonly("line", &PyCommand::line, "The line of a script, in the shortest decimals.")
      .def("__repr__", [](const PyCommand& c) { return "limberg.Command('" + c.line() + "')"; })
      .def(
          "__eq__", [](const PyCommand& a, const PyCommand& b) { return a.line() == b.line(); }, py::arg("other"))
      .def("__hash__", [](const PyCommand& a) { return py::hash(py::str(a.line())); });

  py::class_<Script>(m, "Script", "An operation: a scene's name and its commands in order.")
      .def(py::init(&script_from), py::arg("commands"), py::arg("scene") = "", py::arg("note") = "",
           "Of commands, dicts or lines. InputError names the first that cannot be read.")
      .def_property_readonly(
          "scene", [](const Script& s) { return s.header.scene; }, "Name or path of the scene that it is for.")
      .def_property_readonly(
          "note", [](const Script& s) { return s.header.note; }, "What its header says of it.")
      .def_property_readonly(
          "commands",
          [](const Script& s) {
            py::list out;
            for (const ScriptLine& l : s.lines) out.append(PyCommand{l.command});
            return out;
          },
          "list of Command, in order.")
      .def(
          "to_text", [](const Script& s) { return to_text(s); }, "Header and lines, as a .jsonl file holds them.")
      .def("__len__", [](const Script& s) { return s.lines.size(); });
  m.def("load_script", &load_script, py::arg("path"), "Reads a script (.jsonl). InputError with file and line.");
  m.def(
      "parse_script", [](const std::string& text, const std::string& name) { return parse_script(text, name); },
      py::arg("text"), py::arg("name") = "script", "The same of a text; `name` stands for the file in messages.");
  m.def("actions", &actions_list,
        "Every action of a script: list of dicts with name, form, of_head, help, example, and fields (key, kind, unit, "
        "limits, default, help, required).");
}

}  // namespace limberg::python
