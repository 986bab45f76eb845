#pragma once
// The operation script: JSON lines, one action a line. The actions and
// their keys stand in table.h; `limberg actions` prints them.
//
//   {"limberg_script":1,"scene":"rhomboid","note":"Limberg flap, side 20 mm"}
//   {"action":"incise","path":[[10,0],[30,0]],"depth_mm":4}
//
// The header may also have "landmarks":{"ala":[12,-3]} and "plan" (below).
//
// Reading is strict: an unknown action or key, a key given twice, a wrong type, a number out of its range or a broken
// line is an InputError with the file, the line, what is wrong and what was expected. Nothing is guessed. A field that
// is left out has the value of the command's struct; blank lines are skipped.
// Writing gives the shortest decimals that read back to the same
// numbers, so a script survives any number of round trips.
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/commands/command.h"
#include "sim/commands/script_limits.h"

namespace limberg {

/// A named place on the skin: an eyelid's rim, a nostril's wing.
struct Landmark {
  std::string name;
  ChartPoint at{0, 0};
};

/// A procedure of the repertoire (procedures/catalogue.h) with
///   the values that differ from its own, and where it is laid:
///   "plan":{"procedure":"bilobed","values":{"diameter_mm":12},"at":[0,5],"turn_deg":30,"mirror":true}
struct PlannedProcedure {
  std::string procedure;
  std::vector<std::pair<std::string, double>> values{};
  ChartPoint at{0, 0};
  double turn_deg = 0;
  bool mirrored = false;
};

struct ScriptHeader {
  static constexpr int version = 1;
  std::string scene;  // name of a shipped scene or path of a scene file, as the reader of the script resolves it
  std::string note;
  std::vector<Landmark> landmarks{};       // places whose displacement is measured
  std::optional<PlannedProcedure> plan{};  // the procedure that the script was made from
};

struct ScriptLine {
  int line = 0;  // in the file, from 1
  Command command;
};

struct Script {
  std::string name;  // file, for messages
  ScriptHeader header;
  std::vector<ScriptLine> lines;
};

/// Throws InputError (missing file, directory, too large, or as parse_script).
Script load_script(const std::string& path);
/// `name` stands for the file in messages. Throws InputError.
Script parse_script(std::string_view text, const std::string& name);
/// One line without its header and line end. Throws InputError(name, line, ...).
Command parse_command(std::string_view json_line, const std::string& name, int line);

/// Without line end. Numbers must be finite.
std::string to_json_line(const ScriptHeader& header);
std::string to_json_line(const Command& command);
/// Header and lines, each with its line end.
std::string to_text(const Script& script);

/// The word after "action", for messages and reports.
const char* action_name(const Command& command);

/// Writes a script as it happens: every line is flushed before append returns.
class ScriptWriter {
 public:
  enum class Existing { refuse, replace };
  /// Throws InputError when the file exists (unless replace) or cannot be written.
  ScriptWriter(const std::string& path, const ScriptHeader& header, Existing existing = Existing::refuse);
  ~ScriptWriter();
  ScriptWriter(const ScriptWriter&) = delete;
  ScriptWriter& operator=(const ScriptWriter&) = delete;

  /// Throws InputError when the line could not be written (disk full); lines written before stay whole.
  void append(const Command& command);
  const std::string& path() const { return path_; }

 private:
  void write(const std::string& line);
  std::string path_;
  std::FILE* file_ = nullptr;
};

}  // namespace limberg
