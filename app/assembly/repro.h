#pragma once
// A cut that was refused leaves a small file from which it can be tried again: the scene by name and hash, cell size
// and seed, every command that was carried out before, and the one that was refused.
//
//   {"limberg_repro":1,"program":"...","scene":"rhomboid","scene_hash":"...","cell_mm":3.5,"seed":1,
//    "topology_hash":"...","reason":"...","commands":[{...},...],"refused":{...}}
//
//   limberg check repro-1.json                 says what it holds
//   limberg operate rhomboid repro-1.json      does it all again, with its cell size and seed
//
// topology_hash is that of the state in which the command was refused. Cuts are decided at rest, so the same commands
// lead to it whatever the tissue did in between.
#include <string>
#include <string_view>
#include <vector>

#include "sim/commands/script.h"

namespace limberg {

struct Repro {
  std::string program, scene, reason;
  uint64_t scene_hash = 0, seed = 1, topology_hash = 0;
  double cell_mm = 0;
  std::vector<Command> commands;
  Command refused;
};

std::string to_text(const Repro& repro);
/// Is this the text of one? Looks at its beginning only.
bool looks_like_repro(std::string_view text);
/// InputError (file, line where known) when it is broken.
Repro parse_repro(const std::string& text, const std::string& file);
/// All its commands, the refused one last; lines are their numbers.
Script script_of(const Repro& repro, const std::string& file);

/// Keeps what has been carried out and writes repro-1.json, repro-2.json, ... into a folder: the first numbers that are
/// free, at most kMost by one program. Failing to write is said in `error` and ends the writing; it stops nothing else.
class ReproWriter {
 public:
  static constexpr int kMost = 20;
  /// `blank`: program, scene, scene_hash, seed, cell_mm. An empty folder: nothing is written.
  ReproWriter(std::string dir, Repro blank);
  void done(const Command& command);
  /// Returns the file's name, empty when none was written.
  std::string refused(const Command& command, const std::string& reason, uint64_t topology_hash);
  const std::vector<std::string>& files() const { return files_; }
  const std::string& error() const { return error_; }

 private:
  std::string dir_, error_;
  Repro repro_;
  int last_stroke_ = 0;  // whose refusal is written already
  std::vector<std::string> files_;
};

}  // namespace limberg
