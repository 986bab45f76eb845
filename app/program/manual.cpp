#include "app/program/manual.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <set>
#include <sstream>

#include "app/program/shipped.h"

namespace limberg {

namespace {

std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out = "\\&" + out;
  return out;
}

void options(std::ostringstream& out, const CLI::App& app) {
  for (const CLI::Option* o : app.get_options()) {
    out << ".TP\n.B " << roff(o->get_name(o->get_positional(), true)) << "\n";
    out << roff(o->get_description().empty() ? "As the name says." : o->get_description());
    if (o->get_required()) out << " Required.";
    out << "\n";
  }
}

// The names of an option as typed: "-h", "--help".
std::vector<std::string> names(const CLI::Option& o) {
  std::vector<std::string> n;
  for (const std::string& s : o.get_snames()) n.push_back("-" + s);
  for (const std::string& l : o.get_lnames()) n.push_back("--" + l);
  return n;
}

std::string joined(const std::vector<std::string>& words) {
  std::string s;
  for (const std::string& w : words) s += (s.empty() ? "" : " ") + w;
  return s;
}

}  // namespace

std::string manual_page(const CLI::App& app, const std::string& version) {
  std::ostringstream out;
  out << ".TH LIMBERG 1 \"\" \"" << roff(version)
      << "\" \"User Commands\"\n.SH NAME\nlimberg \\- a trainer for open reconstructive surgery\n";
  out << ".SH SYNOPSIS\n.B limberg\nCOMMAND [OPTIONS]\n.SH DESCRIPTION\n" << roff(app.get_description()) << ".\n";
  out << ".SH COMMANDS\n";
  for (const CLI::App* c : app.get_subcommands({})) {
    out << ".SS limberg " << roff(c->get_name()) << "\n" << roff(c->get_description()) << ".\n";
    options(out, *c);
    std::istringstream footer(c->get_footer());
    for (std::string line; std::getline(footer, line);) out << ".PP\n" << roff(line) << "\n";
  }
  out << ".SH OPTIONS\n";
  options(out, app);
  out << ".SH EXIT STATUS\n0 done; 1 the program failed; 2 the input or the call is wrong; 3 the goal was not "
         "reached.\n";
  return out.str();
}

namespace {

/// The names of the shipped scenes, in order.
std::vector<std::string> scene_names() {
  std::set<std::string> names;
  for (const std::string& root : shipped_roots()) {
    std::error_code ec;
    for (const auto& e : std::filesystem::directory_iterator(root + "/app/scenes", ec))
      if (e.path().extension() == ".toml") names.insert(e.path().stem().string());
    if (!names.empty()) break;
  }
  return {names.begin(), names.end()};
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> commands;
  std::ostringstream cases;
  for (const CLI::App* c : app.get_subcommands({})) {
    commands.push_back(c->get_name());
    std::vector<std::string> words;
    for (const CLI::Option* o : c->get_options())
      for (const std::string& n : names(*o)) words.push_back(n);
    cases << "    " << c->get_name() << ") words=\"" << joined(words) << "\"";
    if (c->get_option_no_throw("SCENE")) cases << " scenes=\"" << joined(scene_names()) << "\"";
    cases << " ;;\n";
  }
  std::ostringstream out;
  out << "# bash completion for limberg, made by limberg --completion\n_limberg() {\n"
         "  local here=${COMP_WORDS[COMP_CWORD]} words= scenes=\n  case \"${COMP_WORDS[1]}\" in\n"
      << cases.str()
      << "  esac\n"
         "  if [ \"$COMP_CWORD\" = 1 ]; then COMPREPLY=($(compgen -W \""
      << joined(commands)
      << " --help --version\" -- \"$here\"))\n"
         "  elif [[ $here == -* ]]; then COMPREPLY=($(compgen -W \"$words\" -- \"$here\"))\n"
         "  else COMPREPLY=($(compgen -W \"$scenes\" -- \"$here\") $(compgen -f -- \"$here\")); fi\n}\ncomplete -o "
         "filenames -F _limberg limberg\n";
  return out.str();
}

}  // namespace limberg
