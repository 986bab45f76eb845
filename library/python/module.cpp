#include "library/python/module.h"

#include "app/program/shipped.h"
#include "app/program/version.h"
#include "sim/base/error.h"

PYBIND11_MODULE(_limberg, m) {
  namespace py = pybind11;
  using namespace limberg;
  using namespace limberg::python;
  m.doc() = "Limberg's library; import limberg, which has all of it.";

  // The program's own words, without "limberg: ".
  static PyObject* const input_error = PyErr_NewExceptionWithDoc(
      "limberg.InputError",
      "Input that cannot be used: 'FILE:LINE: what is wrong; what was expected'. Has file and line (0: all of it).",
      PyExc_ValueError, nullptr);
  static PyObject* const refused = PyErr_NewExceptionWithDoc(
      "limberg.Refused", "An act that the patient refused; nothing has changed. The text is the reason.",
      PyExc_RuntimeError, nullptr);
  m.attr("InputError") = py::handle(input_error);
  m.attr("Refused") = py::handle(refused);
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const InputError& e) {
      const py::object error = py::reinterpret_borrow<py::object>(input_error)(e.what());
      error.attr("file") = e.file(), error.attr("line") = e.line();
      PyErr_SetObject(input_error, error.ptr());
    } catch (const RefusedAct& e) {
      PyErr_SetString(refused, e.reason.c_str());
    }
  });

  m.attr("__version__") = version();
  m.def("program_name", &program_name, "The version and commit that this module was built from.");
  m.def(
      "shipped_file", &shipped_file, py::arg("path"),
      "A file that comes with Limberg, by its path in the tree ('recordings/rhomboid.jsonl'); '' where there is none.");
  add_commands(m);
  add_scenes(m);
  add_world(m);
  add_recordings(m);
}
