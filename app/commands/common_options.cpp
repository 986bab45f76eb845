#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <thread>

#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/result/output.h"

namespace limberg {

void CommonOptions::add_out(CLI::App& c) {
  c.add_option("--out", out_dir, "Folder for pictures, result.json and report.html")->type_name("DIR");
}
void CommonOptions::add_json(CLI::App& c) {
  c.add_option("--json", json_file, "Write the result as JSON to this file")->type_name("FILE");
}
void CommonOptions::add_workers(CLI::App& c) {
  c.add_option("--workers", workers, "Worker threads; results do not depend on it (default: one per core)")
      ->type_name("N")
      ->check(whole_from(1, 256));
  c.add_option(
       "--simd", simd,
       "Instructions of the elasticity kernels (default: the widest of this machine); results do not depend on it")
      ->type_name("SET")
      ->check(CLI::IsMember({"plain", "avx2", "avx512"}));
}

void CommonOptions::add_repro(CLI::App& c) {
  c.add_option("--repro", repro_dir,
               "Folder for repro-N.json, one for each cut that is refused (default: that of --out)")
      ->type_name("DIR");
}

void CommonOptions::add_words(CLI::App& c) {
  c.add_option("--language", wish.language,
               "Of window and pages: en, de (default: LIMBERG_LANGUAGE, or that of the machine)")
      ->type_name("LANGUAGE");
  c.add_option("--words", wish.file, "The table of another language (limberg words)")->type_name("FILE");
}

void CommonOptions::prepare() const {
  words();
  if (!simd.empty())
    setenv("LIMBERG_SIMD", simd.c_str(), 1);  // before any thread and any solver (sim/fem/solver/engine.h)
  if (!out_dir.empty()) prepare_folder(out_dir);
  if (!repro_dir.empty()) prepare_folder(repro_dir);
  if (!json_file.empty()) check_writable(json_file), check_replaces_result(json_file);
}

int CommonOptions::worker_count() const {
  return workers > 0 ? workers : int(std::clamp(std::thread::hardware_concurrency(), 1u, 8u));
}

}  // namespace limberg
