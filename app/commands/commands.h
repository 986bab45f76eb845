#pragma once
// The commands of the program, one file each. A command adds itself to the command
// line and, when it is the one that was asked for, leaves in `chosen` what is to
// be done; that returns the exit status (exit_status.h says what each means).
#include <functional>
#include <string>
#include <vector>

#include "app/words/chosen_words.h"

namespace CLI {
class App;
}

namespace limberg {

using Chosen = std::function<int()>;

enum ExitStatus : int { kDone = 0, kDefect = 1, kBadInput = 2, kGoalMissed = 3 };

void add_run(CLI::App& app, Chosen& chosen);
void add_replay(CLI::App& app, Chosen& chosen);
void add_operate(CLI::App& app, Chosen& chosen);
void add_emulate(CLI::App& app, Chosen& chosen);
void add_check(CLI::App& app, Chosen& chosen);
void add_report(CLI::App& app, Chosen& chosen);
void add_procedure(CLI::App& app, Chosen& chosen);
void add_study(CLI::App& app, Chosen& chosen);
void add_bench(CLI::App& app, Chosen& chosen);  // its name in lists; the suites are those of limberg_bench
/// Starts limberg_bench, which stands beside this program, with these words in place of this process.
/// InputError: it is not there.
int run_bench_beside(const std::vector<std::string>& words);
void add_calibrate(CLI::App& app, Chosen& chosen);
void add_devices(CLI::App& app, Chosen& chosen);
void add_fit(CLI::App& app, Chosen& chosen);
void add_patient(CLI::App& app, Chosen& chosen);
void add_import(CLI::App& app, Chosen& chosen);
void add_export(CLI::App& app, Chosen& chosen);
void add_superpose(CLI::App& app, Chosen& chosen);
void add_design(CLI::App& app, Chosen& chosen);
void add_cases(CLI::App& app, Chosen& chosen);
void add_measures(CLI::App& app, Chosen& chosen);
void add_actions(CLI::App& app, Chosen& chosen);
void add_class(CLI::App& app, Chosen& chosen);
void add_rooms(CLI::App& app, Chosen& chosen);
void add_words(CLI::App& app, Chosen& chosen);

/// Options that several commands share.
struct CommonOptions {
  WordsWish wish;  // of whom the window and the pages are for
  std::string out_dir, json_file, repro_dir;
  std::string simd;
  int workers = 0;  // 0: as many as the machine has cores, at most 8

  void add_out(CLI::App& command);
  void add_json(CLI::App& command);
  void add_workers(CLI::App& command);  // and --simd
  void add_repro(CLI::App& command);
  void add_words(CLI::App& command);  // --language, --words
  /// Where refused cuts leave their files: --repro, or else --out.
  const std::string& repro() const { return repro_dir.empty() ? out_dir : repro_dir; }
  /// Checks before any work that everything can be written. InputError otherwise.
  void prepare() const;
  int worker_count() const;
  /// InputError: no such language, or a table that is not sound.
  Words words() const { return chosen_words(wish); }
};

}  // namespace limberg
