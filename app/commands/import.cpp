#include "app/import/import.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "app/commands/commands.h"
#include "app/commands/numbers.h"
#include "app/result/output.h"
#include "app/scene/scene.h"
#include "sim/base/error.h"
#include "sim/commands/script.h"

namespace limberg {
namespace {

/// Files of that name which an import has not written are left alone.
void check_own(const std::string& stem, const Imported& x, bool replace) {
  std::vector<std::string> files;
  for (const char* ending : {".toml", ".obj", ".jsonl", ".html", ".json"}) files.push_back(stem + ending);
  if (!x.texture.empty()) files.push_back((std::filesystem::path(stem).parent_path() / picture_name(x)).string());
  if (const std::string name = thickness_name(x); !name.empty())
    files.push_back((std::filesystem::path(stem).parent_path() / name).string());
  for (const auto& [name, solid] : solid_files(x))
    files.push_back((std::filesystem::path(stem).parent_path() / name).string());
  for (const std::string& file : files) {
    check_writable(file);
    if (std::error_code ec; !replace && std::filesystem::exists(file, ec))
      throw InputError(file, 0, "exists already; expected a new folder, or --replace");
  }
}

int import(const ImportSettings& s, bool replace, const Words& w) {
  const Imported x = import_peer(s);
  prepare_folder(s.out);
  const std::string stem = (std::filesystem::path(s.out) / x.name).string();
  check_own(stem, x, replace);
  // What is written is read again as a user's would be: a surface that is no body is said here, in its own lines.
  const std::string script = script_text(x), scene_text = scene_toml(x);
  parse_script(script, stem + ".jsonl");
  write_whole_file(stem + ".obj", surface_obj(x));
  for (const auto& [name, solid] : solid_files(x))
    write_whole_file((std::filesystem::path(s.out) / name).string(), collider_obj(*solid));
  if (!x.texture.empty()) write_whole_file((std::filesystem::path(s.out) / picture_name(x)).string(), x.texture);
  if (const std::string name = thickness_name(x); !name.empty())
    write_whole_file((std::filesystem::path(s.out) / name).string(), thickness_text(x));
  write_whole_file(stem + ".toml", scene_text);
  build_body(parse_scene(scene_text, stem + ".toml"));
  write_whole_file(stem + ".jsonl", script);
  write_whole_file(stem + ".html", import_page(x, w));
  write_whole_file(stem + ".json", import_json(x));

  using Fate = CarriedAct::Fate;
  const int refused = x.operation.count(Fate::refused);
  std::printf("%s: one unit is %g mm%s\n", x.scene.object.c_str(), x.unit_mm,
              x.unit_guessed ? " (guessed by the model's size; --unit-mm says otherwise)" : "");
  std::printf("%zu acts: %d carried, %d changed, %d refused\n", x.operation.act.size(),
              x.operation.count(Fate::carried), x.operation.count(Fate::changed), refused);
  for (const CarriedAct& a : x.operation.act) {
    if (a.fate != Fate::refused) continue;
    std::string why;
    for (const std::string& n : a.notes) why += (why.empty() ? "" : "; ") + n;
    std::fprintf(stderr, "limberg: %s:%d: %s refused: %s\n", x.history_file.c_str(), a.line, a.words.c_str(),
                 why.c_str());
  }
  std::printf("%s.toml, .obj, .jsonl; the account of every act: %s.html\n", stem.c_str(), stem.c_str());
  std::printf("limberg operate %s.toml %s.jsonl --keep-going --out %s-operated carries it out\n", stem.c_str(),
              stem.c_str(), stem.c_str());
  return refused > 0 ? kGoalMissed : kDone;
}

}  // namespace

void add_import(CLI::App& app, Chosen& chosen) {
  struct Options {
    ImportSettings settings;
    bool replace = false;
    CommonOptions common;
  };
  auto o = std::make_shared<Options>();
  CLI::App* c = app.add_subcommand(
      "import", "A peer's recorded operation (SkinFlaps) as a scene and a script, with an account of every act");
  c->add_option("FILE", o->settings.input, "A history (.hst), or a scene alone (.smd)")->required();
  c->add_option("--models", o->settings.models, "Where scene, models and deep points lie, if not beside FILE")
      ->type_name("DIR")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  c->add_option("--out", o->settings.out, "Folder for NAME.toml, .obj, .jsonl, .html and .json")
      ->type_name("DIR")
      ->required();
  c->add_option("--unit-mm", o->settings.unit_mm,
                "Millimetres of one unit of the models [10; 20 for a model less than 10 units long]")
      ->check(number_from(0.001, 1000));
  c->add_option("--cell-mm", o->settings.cell_mm, "Of the scene's lattice [four cells of the peer's, 1.5 to 5]")
      ->check(number_from(0.2, 50));
  c->add_option("--spacing-mm", o->settings.spacing_mm,
                "Between the stitches of a row [six cells of the peer's, 1.5 to 3]")
      ->check(number_from(0.5, 20));
  c->add_flag("--replace", o->replace, "Replace files of an earlier import");
  o->common.add_words(*c);
  c->footer(
      "Exit status 3: some acts were refused; all others are in the script.\n"
      "Example: limberg import flaps/cheek.hst --models flaps/model --out out/cheek\n"
      "         limberg check out/cheek/cheek.toml --plan\n"
      "         limberg operate out/cheek/cheek.toml out/cheek/cheek.jsonl --keep-going --out out/cheek/operated");
  c->callback([o, &chosen] { chosen = [o] { return import(o->settings, o->replace, o->common.words()); }; });
}

}  // namespace limberg
