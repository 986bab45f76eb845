// What was carried, for people (HTML) and programs (JSON).
#include <fmt/format.h>

#include "app/import/import.h"
#include "app/program/version.h"
#include "app/report/elements.h"
#include "app/report/page.h"
#include "app/result/json_nesting.h"
#include "app/result/result.h"
#include "app/result/schema.h"

namespace limberg {
namespace {

using Fate = CarriedAct::Fate;

/// acts: of the operation. script: its lines there.
struct ResultCarried {
  int line = 0, places = 0;
  std::string name, fate;
  std::vector<std::string> notes;
  double moved_mm = 0;
  int script_from = 0, script_to = 0;
};
void fields(ResultCarried& x, auto&& f) {
  f("line", x.line), f("name", x.name), f("fate", x.fate), f("notes", x.notes), f("places", x.places);
  f("moved_mm", x.moved_mm), f("script_from", x.script_from), f("script_to", x.script_to);
}
struct ResultImport {
  std::string history, model, deep_points;
  double unit_mm = 0, cell_mm = 0, region_mm = 0, skin_mm = 0, displacement_mm = 0, moved_max_mm = 0;
  bool unit_guessed = false;
  int64_t triangles = 0, held = 0, carried = 0, changed = 0, refused = 0, passed = 0, places = 0;
  std::vector<ResultCarried> acts;
  std::vector<std::string> mended, missing;
};
void fields(ResultImport& x, auto&& f) {
  f("history", x.history), f("model", x.model), f("deep_points", x.deep_points), f("unit_mm", x.unit_mm);
  f("unit_guessed", x.unit_guessed), f("cell_mm", x.cell_mm), f("region_mm", x.region_mm), f("skin_mm", x.skin_mm);
  f("displacement_mm", x.displacement_mm), f("triangles", x.triangles), f("held", x.held), f("carried", x.carried);
  f("changed", x.changed), f("refused", x.refused), f("passed", x.passed), f("places", x.places);
  f("moved_max_mm", x.moved_max_mm), f("acts", x.acts), f("mended", x.mended), f("missing", x.missing);
}

html::Light light_of(Fate fate) {
  return fate == Fate::refused   ? html::Light::bad
         : fate == Fate::changed ? html::Light::warn
         : fate == Fate::carried ? html::Light::good
                                 : html::Light::none;
}

std::vector<html::Markup> items(const std::vector<std::string>& lines, const Words& w) {
  std::vector<html::Markup> out;
  for (const std::string& l : lines) out.emplace_back(w.said(l));
  return out;
}

double most_moved(const CarriedOperation& o) {
  double most = 0;
  for (const CarriedAct& a : o.act) most = std::max(most, a.moved_mm);
  return most;
}
int places_of(const CarriedOperation& o) {
  int n = 0;
  for (const CarriedAct& a : o.act) n += a.places;
  return n;
}

}  // namespace

std::string import_page(const Imported& x, const Words& w) {
  const CarriedOperation& o = x.operation;
  Page page;
  page.title = x.name, page.heading = x.name;
  page.w = w;
  page.opening =
      html::paragraph(w("A peer's recorded operation as a scene and a script of ours. {} as {}.toml and {}.obj, {} "
                        "triangles, of which {} "
                        "are held; one unit of the file is {:g} mm{}.",
                        x.scene.object, x.name, x.name, x.triangles, x.held, x.unit_mm,
                        x.unit_guessed ? w(", guessed by its size (--unit-mm says otherwise)") : ""));
  const int refused = o.count(Fate::refused);
  page.summary =
      html::verdict(refused > 0 ? html::Light::bad : html::Light::good,
                    refused > 0 ? w("{} of {} acts were refused.", refused, o.act.size())
                                : w("Every one of {} acts was carried.", o.act.size())) +
      html::cards(
          {{std::to_string(o.count(Fate::carried)), w("carried"), w("as they are")},
           {std::to_string(o.count(Fate::changed)), w("changed"), w("carried otherwise than recorded")},
           {std::to_string(refused), w("refused"), w("left out, for the reason given")},
           {w("{:.2f} mm", most_moved(o)), w("a place moved, at most"),
            w("of {} places, from where the file has it to the surface or the cut it was laid on", places_of(o))}});
  std::vector<html::Row> rows;
  for (const CarriedAct& a : o.act) {
    html::Markup notes;
    for (const std::string& n : a.notes) notes += (notes.empty() ? html::Markup() : html::Markup("; ")) + w.said(n);
    rows.push_back({std::to_string(a.line), w.said(a.words) + (a.name.empty() ? "" : " (" + a.name + ")"),
                    html::Cell(w(words_of(a.fate)), light_of(a.fate)), a.places ? w("{:.2f}", a.moved_mm) : "",
                    a.first == 0        ? ""
                    : a.first == a.last ? std::to_string(a.first)
                                        : w("{} to {}", a.first, a.last),
                    notes});
  }
  page.sections = html::section(
      w("Each act"),
      html::table_of_words({w("line"), w("act"), w("fate"), w("moved, mm"), w("line of the script"), w("why")}, rows));
  page.sections += html::section(w("What our scene has not"), html::list(items(x.missing, w)));
  page.sections += html::section(w("Let pass in the files"), html::list(items(x.mended, w)));
  page.sections +=
      html::section(w("Carry it out"), html::lines(fmt::format("limberg check {}.toml --plan\nlimberg operate {}.toml "
                                                               "{}.jsonl --keep-going --out out",
                                                               x.name, x.name, x.name)));
  page.footer = html::Markup(program_name());
  return text_of(page);
}

std::string import_json(const Imported& x) {
  const CarriedOperation& o = x.operation;
  Result r("import", x.name + ".toml");
  ResultImport out;
  out.history = x.history_file, out.model = x.model_file, out.deep_points = x.bed_file;
  out.unit_mm = x.unit_mm, out.unit_guessed = x.unit_guessed, out.cell_mm = x.cell_mm, out.region_mm = x.region_mm;
  out.skin_mm = x.skin_mm, out.displacement_mm = x.model.history_mm, out.triangles = x.triangles, out.held = x.held;
  out.carried = o.count(Fate::carried), out.changed = o.count(Fate::changed), out.refused = o.count(Fate::refused);
  out.passed = o.count(Fate::passed), out.places = places_of(o), out.moved_max_mm = most_moved(o);
  for (const CarriedAct& a : o.act)
    out.acts.push_back({a.line, a.places, a.name, words_of(a.fate), a.notes, a.moved_mm, a.first, a.last});
  out.mended = x.mended, out.missing = x.missing;
  write_fields(r, "", out);
  r.set_ok(out.refused == 0);
  return r.text();
}

}  // namespace limberg
