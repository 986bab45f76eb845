#include "app/scene/tissues.h"

#include <filesystem>

#include "app/program/shipped.h"
#include "app/scene/scene_layers.h"

namespace limberg {

namespace fs = std::filesystem;

const NamedTissue* TissueLibrary::find(const std::string& name) const {
  for (const NamedTissue& t : tissues)
    if (t.name == name) return &t;
  return nullptr;
}

std::string TissueLibrary::names() const {
  std::string s;
  for (const NamedTissue& t : tissues) s += (s.empty() ? "" : ", ") + t.name;
  return s;
}

TissueLibrary parse_tissues(const std::string& text, const std::string& path, const LawCatalogue& laws) {
  TissueLibrary out{path, text, {}};
  const toml::table root = parse_toml(text, path, "a library of tissues");
  for (const auto& [k, n] : root)
    if (k.str() != "tissue" && k.str() != "note")
      throw InputError(path, int(n.source().begin.line),
                       "unknown key in a library of tissues; expected note and [[tissue]]");
  const toml::node* n = root.get("tissue");
  const toml::array* a = n ? n->as_array() : nullptr;
  if (!a || a->empty())
    throw InputError(path, n ? int(n->source().begin.line) : 0, "no tissue; expected at least one [[tissue]]");
  for (const toml::node& e : *a) {
    if (!e.is_table())
      throw InputError(path, int(e.source().begin.line), "a tissue is not a table; expected [[tissue]]");
    const toml::table& table = *e.as_table();
    Table t(&table, "tissue", path);
    NamedTissue x;
    if (!t.has("name")) t.fail("name", "is missing; expected a name like \"skin/cheek\"");
    t.text("name", x.name, 40);
    if (out.find(x.name)) t.fail("name", "is \"" + x.name + "\" for the second time; expected names of their own");
    t.text("note", x.note, 2000);
    t.real("thickness_mm", x.thickness_mm, 0, 100, true);
    x.material = unknown_material();
    read_material(t, x.material, laws);
    x.material.tissue = x.name;
    const toml::table* source = t.table("source");
    t.finish();
    if (!source) t.fail("source", "is missing; expected [tissue.source] with where each value comes from");
    Table s(source, "tissue.source", path);
    for (const auto& [key, value] : table) {
      const std::string k(key.str());
      if (k == "name" || k == "note" || k == "source" || k == "law") continue;
      if (!s.has(k.c_str()))
        throw InputError(
            path, int(value.source().begin.line),
            "tissue " + x.name + ": " + k + " has no source; expected " + k + " = \"...\" in [tissue.source]");
      s.text(k.c_str(), x.source.emplace_back(k, "").second, 1000);
    }
    s.finish();
    out.tissues.push_back(std::move(x));
  }
  return out;
}

std::string find_tissues(const std::string& scene_path) {
  const fs::path folder = fs::path(scene_path).parent_path();
  std::error_code ec;
  for (const fs::path& p : {folder / "tissues.toml", folder / ".." / "tissues.toml", folder / "../scene/tissues.toml",
                            fs::path(shipped_file("app/scene/tissues.toml"))})
    if (fs::is_regular_file(p, ec)) return p.lexically_normal().string();
  return {};
}

}  // namespace limberg
