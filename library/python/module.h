#pragma once
// import limberg: what each file of the module adds to it, and what they share.
//
// Errors. InputError becomes limberg.InputError, a refused act limberg.Refused, in the words that the program prints.
// Threads. A long call (step, settle, operate, reading a file) lets other Python threads run. One patient is for one
// thread at a time; several patients may be used at once.
#include <pybind11/pybind11.h>

#include <memory>
#include <string>

#include "app/scene/scene.h"
#include "sim/commands/script.h"

namespace limberg::python {

namespace py = pybind11;

/// A command as scripts hold it, in Python a value.
struct PyCommand {
  Command command;
  std::string line() const { return to_json_line(command); }
};
/// Of a limberg.Command, a dict {"action": ..., ...} or a line of a script. InputError as the reader of scripts.
Command command_of(const py::handle& told);

/// A scene, with what its files need while they are read.
struct PyScene {
  Scene scene;
  std::shared_ptr<void> files;
};

/// What World.apply throws for an act that was refused.
struct RefusedAct {
  std::string reason;
};

void add_commands(py::module_& m);
void add_scenes(py::module_& m);
void add_world(py::module_& m);
void add_recordings(py::module_& m);

}  // namespace limberg::python
