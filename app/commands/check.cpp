#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string_view>

#include "app/assembly/bundle.h"
#include "app/assembly/lesson.h"
#include "app/assembly/repro.h"
#include "app/commands/length_unit.h"
#include "app/commands/session_command.h"
#include "app/head/build.h"
#include "app/program/shipped.h"
#include "app/result/output.h"
#include "app/result/progress.h"
#include "app/result/tables.h"
#include "app/scene/first_scene.h"
#include "app/scene/tissues.h"
#include "app/session/clock.h"
#include "app/session/workers_pool.h"
#include "sim/base/error.h"
#include "sim/body/obj.h"
#include "sim/commands/procedures/plan_drawing.h"
#include "sim/commands/script.h"
#include "sim/commands/strokes.h"
#include "sim/commands/table.h"
#include "sim/imaging/io/dicom.h"
#include "sim/imaging/io/surface_file.h"
#include "sim/imaging/io/volume.h"
#include "sim/measure/predicted.h"
#include "sim/patient/soft_tissue.h"
#include "sim/skull/simplex/file.h"

namespace limberg {

namespace {

enum class Kind { scene, lesson, tissues, script, repro, recording, calibration, surface, simplex_mesh };

constexpr size_t kBeginning = 4096;
bool begins_recording(std::string_view text) {
  return text.substr(0, kBeginning).find("\xED\xA1\xDA\x01") != std::string_view::npos;
}

/// What a file is, by what is in it; its name decides only where the content leaves a doubt.
Kind recognise(const std::string& file, std::string_view text) {
  const auto ends = [&](const char* e) { return std::string_view(file).ends_with(e); };
  if (begins_recording(text)) return Kind::recording;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos)
    throw InputError(file, 0,
                     "is empty; expected a scene, a lesson, a library of tissues, a script, a recording, a calibration "
                     "or an OBJ surface");
  if (looks_like_repro(text)) return Kind::repro;
  if (text.substr(first).starts_with("limberg-simplex")) return Kind::simplex_mesh;
  if (text[first] == '{' || ends(".jsonl")) return Kind::script;
  if (text.find('\0') != std::string_view::npos) {
    if (ends(".lcm")) return Kind::recording;
    throw InputError(file, 0,
                     "is of no kind that is known here; expected a scene, a lesson, a library of tissues, a script, a "
                     "recording, a calibration or an OBJ surface");
  }
  if (text.find("limberg_calibration") != std::string_view::npos) return Kind::calibration;
  if (ends(".lcm")) return Kind::recording;
  if (text.find("[[tissue]]") != std::string_view::npos && text.find("[body]") == std::string_view::npos)
    return Kind::tissues;
  if (looks_like_lesson(text) &&
      (text.find("[procedure]") != std::string_view::npos || text.find("[[bone.piece]]") != std::string_view::npos ||
       text.find("\nby_script") != std::string_view::npos))
    return Kind::lesson;
  if (ends(".toml")) return Kind::scene;
  if (ends(".obj")) return Kind::surface;
  if (text.find("\nv ") != std::string_view::npos || text.starts_with("v ")) return Kind::surface;
  if (text.find("[body]") != std::string_view::npos) return Kind::scene;
  throw InputError(file, 0,
                   "is of no kind that is known here; expected a scene, a lesson, a library of tissues, a script, a "
                   "recording, a calibration or an OBJ surface");
}

void print_surface(const SurfaceReport& s) {
  std::printf("surface     closed, %lld triangles, %lld vertices, genus %d, %.1f cm3, %.1f cm2\n",
              static_cast<long long>(s.triangles), static_cast<long long>(s.vertices), s.genus, s.volume_mm3 * 1e-3,
              s.area_mm2 * 1e-2);
}

std::string constants_of(const Material& m) {
  std::string s;
  for (const auto& c : m.law.constants) {
    s += (s.empty() ? "" : ", ") + c.key + " ";
    for (size_t i = 0; i < c.value.size(); ++i) s += fmt::format("{}{:.6g}", i ? " " : "", c.value[i]);
  }
  return s;
}

/// Only what differs from the plain case.
void print_law(const Material& m) {
  if (!m.tissue.empty()) std::printf("  tissue    %s\n", m.tissue.c_str());
  if (!m.law.name.empty()) std::printf("  law       %s: %s\n", m.law.name.c_str(), constants_of(m).c_str());
  for (const PronyTerm& p : m.prony) std::printf("  relaxes   %.3g %% in %.4g s\n", 100 * p.share, p.time_s);
}

/// Of a layer that is not as thick everywhere.
void print_thickness(const Body& body, size_t layer) {
  if (layer >= body.thickness_mm.size() || body.thickness_mm[layer].empty()) return;
  std::vector<float> skin;  // beneath it
  for (size_t t = 0; t < body.surface.tri.size(); ++t)
    if (body.surface.tag.empty() || body.surface.tag[t] == SurfaceTag::skin)
      for (const int32_t v : body.surface.tri[t]) skin.push_back(body.thickness_mm[layer][size_t(v)]);
  if (skin.empty()) return;
  std::sort(skin.begin(), skin.end());
  std::printf("  thickness by place %.3g to %.3g mm, %.3g in the middle\n", double(skin.front()), double(skin.back()),
              double(skin[skin.size() / 2]));
}

void check_tissues(const TissueLibrary& library) {
  std::printf("tissues     %zu\n", library.tissues.size());
  for (const NamedTissue& t : library.tissues) {
    const Material& m = t.material;
    std::printf("\n%s\n", t.name.c_str());
    if (!t.note.empty()) std::printf("  %s\n", t.note.c_str());
    std::printf("  %.4g kPa at small strain, Poisson %.3g, prestretch %.3g along, %.3g across", m.young_kPa, m.poisson,
                m.prestretch_along, m.prestretch_across);
    std::printf(t.thickness_mm > 0 ? ", %.3g mm thick\n" : "\n", t.thickness_mm);
    print_law(m);
    for (const auto& [key, from] : t.source) std::printf("    %-18s %s\n", key.c_str(), from.c_str());
  }
  std::printf("\nlaws\n");
  for (const auto& e : shipped_laws()->entries()) {
    std::printf("  %s: %s\n", e.name.c_str(), e.about.c_str());
    for (const auto& c : e.constants)
      std::printf("    %-18s %s%s %g to %g%s\n", c.key.c_str(), c.most_values > 1 ? "list of " : "",
                  c.above ? "above" : "from", c.least, c.most, c.required ? "" : ", optional");
  }
}

/// The law of every layer: where its energy is kept, its points in a full cell's share, the time of one visit.
void plan_laws(const Scene& scene, const FemModel& m) {
  std::map<const MaterialLaw*, size_t> points;
  size_t viscous = 0;
  for (const HexCell& c : m.cells) {
    const Stencil& s = m.stencils[size_t(c.stencil)];
    for (const MaterialPoint& p : s.points) ++points[m.laws[size_t(p.law)].get()];
    viscous += s.viscous.size();
  }
  size_t next = 0;
  for (const Layer& l : scene.layers()) {
    const LayerResponse r = layer_response(l.material, scene.laws.get());
    const char* name = l.material.law.name.empty() ? kDefaultLaw : l.material.law.name.c_str();
    std::printf("  law       %s: %s", l.name.c_str(), name);
    if (!r.points) std::printf(", in the constants of its cells: no cost\n");
    while (r.points && next < m.laws.size() && m.laws[next]->describe() != r.points->describe()) ++next;
    if (r.points && next < m.laws.size()) {
      const MaterialLaw& law = *m.laws[next++];
      constexpr int visits = 20000;
      double sum = 0;
      const int64_t t0 = RealClock::monotonic_ns();
      for (int i = 0; i < visits; ++i) sum += law.at(Mat3(Vec3(1.1 + 1e-6 * i, 1.05, 0.87).asDiagonal())).energy_kPa;
      const double ns = double(RealClock::monotonic_ns() - t0) / visits;
      std::printf("%s, %zu points of %.0f ns: %.2f ms an iteration on one core%s\n",
                  r.matrix_mu_kPa > 0 ? ", matrix in the constants of its cells" : "", points[&law], ns,
                  ns * 1e-6 * double(points[&law]), sum < 0 ? " " : "");
    }
    if (!l.material.prony.empty() && !scene.dynamic)
      std::printf(
          "            its relaxation is not used: the scene is quasi-static ([build] dynamic = true uses it)\n");
  }
  if (viscous > 0) std::printf("  relaxes   %zu points%s\n", viscous, scene.dynamic ? "" : ", unused");
}

void print_head_scene(const HeadScene& h) {
  if (h.source == HeadScene::Source::synthetic)
    std::printf(
        "head        synthetic: mandible %.3g, left ramus %.3g, vault %.3g wide and %.3g long, forehead set back %.3g; "
        "edges %.3g and %.3g mm\n",
        h.mandible_scale, h.ramus_left, h.vault_wide, h.vault_long, h.forehead_flat, h.edge_mm, h.face_edge_mm);
  if (h.source == HeadScene::Source::anatomical)
    std::printf("head        anatomical, of average measures: edges up to %.3g and %.3g mm\n", h.edge_mm,
                h.face_edge_mm);
  for (const std::string& f : h.bone_files) std::printf("head        bone %s\n", f.c_str());
  if (!h.face_file.empty()) std::printf("head        face %s\n", h.face_file.c_str());
  for (const std::string& f : h.normal_files) std::printf("head        normal skull %s\n", f.c_str());
  if (!h.face) std::printf("head        no face\n");
  for (const HeadScene::TissueAt& t : h.tissues)
    std::printf("tissue      %s, %d layers of %.4g kPa, %s, %s on the face\n", t.tissue.name.c_str(), t.tissue.layers,
                t.tissue.young_kPa, kTissueKinds[size_t(t.tissue.mode)],
                t.outline_names.empty() ? fmt::format("{:.3g} mm around", t.tissue.face_radius_mm).c_str()
                                        : fmt::format("within {} places", t.outline_names.size()).c_str());
  for (const HeadScene::MuscleAt& m : h.muscles)
    std::printf("muscle      %s, %.3g mm about a line of %zu places, %.4g kPa%s\n", m.bundle.name.c_str(),
                m.bundle.radius_mm, m.names.size(), m.bundle.young_kPa,
                m.bundle.k1_kPa > 0 ? fmt::format(" between fibres of {:.4g} kPa", m.bundle.k1_kPa).c_str() : "");
  for (const HeadScene::SlideAt& s : h.slides)
    std::printf("slide       %s, %.3g mm around on bone, %.3g kPa a mm\n", s.slide.name.c_str(), s.slide.radius_mm,
                s.slide.kPa_per_mm);
}

void check_scene(const Scene& scene) {
  if (!scene.flesh) {
    std::printf("scene       %s\n", scene.name.c_str());
    if (!scene.note.empty()) std::printf("            %s\n", scene.note.c_str());
    print_head_scene(*scene.head);
    std::printf("hash        %s\n", hex(scene.hash).c_str());
    return;
  }
  SurfaceReport surface;
  const auto body = build_body(scene, &surface);
  std::printf("scene       %s\n", scene.name.c_str());
  if (!scene.note.empty()) std::printf("            %s\n", scene.note.c_str());
  if (surface.triangles == 0)
    surface.triangles = int64_t(body->surface.tri.size()), surface.vertices = int64_t(body->surface.X_mm.size());
  if (surface.volume_mm3 > 0)
    print_surface(surface);
  else
    std::printf("surface     %lld triangles, %lld vertices\n", static_cast<long long>(surface.triangles),
                static_cast<long long>(surface.vertices));
  const Vec3 size = body->box_max_mm - body->box_min_mm;
  std::printf("size        %.1f x %.1f x %.1f mm\n", size.x(), size.y(), size.z());
  if (scene.tension.given())
    std::printf("tension     lines by place%s%s\n", scene.tension.file.empty() ? "" : ": ", scene.tension.file.c_str());
  for (const Layer& l : body->layers) {
    std::printf("layer       %s, %.3g mm, %.3g kPa, Poisson %.3g, prestretch %.3g along, %.3g across\n", l.name.c_str(),
                l.thickness_mm, l.material.young_kPa, l.material.poisson, l.material.prestretch_along,
                l.material.prestretch_across);
    print_thickness(*body, size_t(&l - body->layers.data()));
    print_law(l.material);
  }
  for (const auto& r : body->regions) {
    std::printf("region      %s, %.3g kPa, Poisson %.3g, prestretch %.3g along, %.3g across\n", r->name().c_str(),
                r->material().young_kPa, r->material().poisson, r->material().prestretch_along,
                r->material().prestretch_across);
    print_law(r->material());
  }
  if (scene.head) print_head_scene(*scene.head);
  std::printf("hash        %s\n", hex(scene.hash).c_str());
}

/// What a head is made of, built to be measured.
void plan_head(const Scene& scene, Workers& workers) {
  const double before_mb = peak_memory_mb();
  const int64_t t0 = RealClock::monotonic_ns();
  Head head(head_parts(scene, workers), workers);
  const int64_t t1 = RealClock::monotonic_ns();
  Histogram step;
  for (int i = 0; i < 20; ++i) {
    const int64_t a = RealClock::monotonic_ns();
    head.step(1 / scene.steps_per_s);
    step.add(RealClock::monotonic_ns() - a);
  }
  std::printf("plan        head built in %.2f s\n", double(t1 - t0) * 1e-9);
  std::printf("  bones     %zu, %d vertices\n", head.bones().fragments().size(), head.bones().mesh().vertices());
  std::printf("  face      %d vertices\n", head.face().vertices());
  size_t tissue = 0;
  for (const simplex::Tissue* t : head.face_model().tissues()) tissue += size_t(t->vertices());
  std::printf("  tissue    %zu regions, %zu vertices\n", head.tissues().size(), tissue);
  std::printf("  landmarks %zu\n", head.landmarks().size());
  std::printf("  not built %sBullet world (until a fragment is held)\n",
              scene.flesh ? "" : "lattice, cutter, elastic solver, ");
  std::printf("  memory    %.0f MB, of which the head %.0f MB\n", peak_memory_mb(), peak_memory_mb() - before_mb);
  std::printf(
      "  step      %.2f ms median at rest; %d iterations while something moves (%.0f steps a second wanted; limberg "
      "bench head measures them)\n",
      double(step.percentile_ns(0.5)) * 1e-6, scene.head->iterations_per_step, scene.steps_per_s);
}

/// Builds what the scene asks for and says what came of it: the only plan that cannot be wrong.
void plan(const Scene& scene, int workers_n) {
  WorkersPool workers(workers_n);
  if (scene.head) plan_head(scene, workers);
  if (!scene.flesh) return;
  const auto body = build_body(scene);
  const double before_mb = peak_memory_mb();
  const int64_t t0 = RealClock::monotonic_ns();
  World world(world_spec(scene, body), workers);
  const int64_t t1 = RealClock::monotonic_ns();
  const FemModel& m = world.skin()->solver().model();
  StepSettings s;
  s.max_iterations = scene.iterations_per_step;
  Histogram step;
  for (int i = 0; i < 20; ++i) {
    const int64_t a = RealClock::monotonic_ns();
    world.step(s);
    step.add(RealClock::monotonic_ns() - a);
  }
  std::printf("plan        built in %.2f s with %d workers\n", double(t1 - t0) * 1e-9, workers_n);
  std::printf("  lattice   %zu nodes, %zu cells of %.2f x %.2f x %.2f mm\n", m.X_mm.size(), m.cells.size(),
              m.cell_mm.x(), m.cell_mm.y(), m.cell_mm.z());
  plan_laws(scene, m);
  std::printf("  solver    %s\n", world.skin()->solver().describe().c_str());
  std::printf("  parts     %s%s\n", scene.can_cut ? "cutter" : "no cutter",
              scene.dynamic ? ", dynamics" : ", quasi-static");
  std::printf("  not built %shaptic contact model (not asked for)\n", scene.head ? "" : "bone, simplex meshes, ");
  std::printf("  memory    %.0f MB, of which the patient %.0f MB\n", peak_memory_mb(), peak_memory_mb() - before_mb);
  std::printf("  step      %.2f ms median of %d iterations (%.0f steps a second wanted)\n",
              double(step.percentile_ns(0.5)) * 1e-6, scene.iterations_per_step, scene.steps_per_s);
}

/// What the plan foretells: the angles that do not add up, and a drawing when one is asked for.
void foretell(const Skin& skin, const std::optional<PlanOnSkin>& plan, const std::string& title,
              const std::string& svg) {
  if (!plan) {
    if (!svg.empty())
      throw InputError(title, 0,
                       "shows no plan that is known; expected \"plan\" in its header, a Z-plasty or a rhombic flap");
    std::printf("plan        none that is known: no \"plan\" in the header, no Z-plasty, no rhombic flap\n");
    return;
  }
  double sum = 0;
  for (const Charge& c : charges(plan->figure)) {
    sum += c.q_deg;
    if (std::abs(c.q_deg) < 20) continue;  // spread along a curve
    const ChartPoint at = plan->chart(c.meeting.front());
    if (!skin.at(at)) throw InputError(title, 0, "its plan leaves the skin; expected a place with more skin around it");
    std::printf("plan        %s of %+.0f degrees where (%.1f, %.1f) comes to lie\n",
                c.q_deg > 0 ? "dog-ear" : "saddle ", c.q_deg, unsigned_zero(at.x()), unsigned_zero(at.y()));
  }
  std::printf("plan        all charges together %.3g degrees (0: it closes to one sheet)\n",
              std::abs(sum) < 1e-6 ? 0 : sum);
  if (svg.empty()) return;
  check_replaces_drawing(svg);
  write_whole_file(svg, plan_svg(plan->figure, title));
  std::printf("drawn       %s\n", svg.c_str());
}

Scene scene_of(const std::string& file, const std::string& name) {
  std::error_code ec;
  if (const auto beside = std::filesystem::path(file).parent_path() / name;
      name.ends_with(".toml") && !std::filesystem::exists(name, ec) && std::filesystem::is_regular_file(beside, ec))
    return open_scene(beside.string());  // an imported operation and its scene lie in one folder
  if (!std::filesystem::exists(name, ec) && shipped_file("app/scenes/" + name + ".toml").empty())
    throw InputError(file, 1,
                     "names the scene \"" + name.substr(0, 100) +
                         "\", which is not there; expected a scene file or the name of a shipped scene");
  return open_scene(name);
}

void check_script(const Script& script, const std::string& file, bool with_plan, const std::string& svg) {
  const Scene scene = scene_of(file, script.header.scene);
  std::printf("script      %zu actions for scene \"%s\"\n", script.lines.size(), script.header.scene.c_str());
  if (!script.header.note.empty()) std::printf("            %s\n", script.header.note.c_str());
  std::map<std::string, int> count;
  std::vector<Command> commands;
  for (const ScriptLine& l : script.lines) {
    const Needs needs = visit_act(l.command, []<class C>(const C&) { return Act<C>::needs; });
    if (needs == Needs::head && !scene.head)
      throw InputError(file, l.line,
                       std::string(action_name(l.command)) + " asks for a head, and the scene \"" + scene.name +
                           "\" has none; expected a scene with a [head]");
    if (needs == Needs::skin && !scene.flesh)
      throw InputError(file, l.line,
                       std::string(action_name(l.command)) + " asks for skin, and the scene \"" + scene.name +
                           "\" has none; expected a scene with a [body]");
  }
  for (const ScriptLine& l : script.lines) ++count[action_name(l.command)];
  commands = acts_on(scene, script);
  for (const auto& [name, n] : count) std::printf("  %-14s %d\n", name.c_str(), n);
  if ((!with_plan && svg.empty()) || !scene.flesh) return;
  const Skin skin(build_body(scene));
  foretell(skin, plan_of(skin, script.header.plan, join_strokes(commands)),
           script.header.note.empty() ? file : script.header.note, svg);
}

void tell_lesson(const Lesson& l) {
  std::printf("lesson      %s\n            %s\nscene       %s\n", l.title.c_str(), l.goal.c_str(), l.scene.c_str());
}
void tell_tolerances(const Lesson& l) {
  for (const auto& [name, limit] : l.tolerances) std::printf("  at most   %s %g\n", name.c_str(), limit);
  const size_t steps = std::max(l.steps.size(), l.words.steps.size());  // told in a list, or each with its words
  std::printf("steps       %zu\nhints       %zu\n", steps, l.hints.size());
}

/// Landmarks and figures that it names are there.
void check_bone_lesson(const Lesson& l) {
  tell_lesson(l);
  for (const PlannedPiece& p : l.bone->pieces) {
    std::string names;
    for (const std::string& n : p.holds) names += " " + n;
    const Vec3 &t = p.move.translation_mm, &r = p.move.rotation_deg;
    std::printf("piece       %s, with%s: by (%g, %g, %g) mm, turned by (%g, %g, %g) degrees\n", p.name.c_str(),
                names.c_str(), t.x(), t.y(), t.z(), r.x(), r.y(), r.z());
  }
  tell_tolerances(l);
  const Scene scene = scene_of(l.file, l.scene);
  if (!scene.head) throw InputError(l.file, 0, "is a lesson on bones, and its scene has no [head]; expected one");
  WorkersPool workers(1);
  if (const std::string missing = plan_lacks(*l.bone, head_parts(scene, workers).landmarks); !missing.empty())
    throw InputError(l.file, 0, "asks for what its head lacks: " + missing + "; expected its landmarks");
}

void check_lesson(const Lesson& l, bool with_plan, const std::string& svg) {
  if (l.bone) return check_bone_lesson(l);
  const Skin skin(build_body(scene_of(l.file, l.scene)));
  if (l.by_script) {
    if (with_plan || !svg.empty())
      throw InputError(l.file, 0,
                       "has its script for a plan; expected no --plan and no --draw, or those of the script");
    tell_lesson(l);
    std::printf("plan        its script\n");
    return tell_tolerances(l);
  }
  const PlannedProcedure& p = *l.plan;
  const PlanOnSkin plan = plan_on(skin, p);
  tell_lesson(l);
  std::printf("procedure   %s at (%g, %g) mm, turned by %g degrees%s\n", p.procedure.c_str(), p.at.x(), p.at.y(),
              p.turn_deg, p.mirrored ? ", mirrored" : "");
  tell_tolerances(l);
  // Every corner of the plan lies on the skin, or the lesson cannot be done.
  for (const auto* lines : {&plan.figure.excisions, &plan.figure.incisions})
    for (const auto& line : *lines)
      for (const Vec2& corner : line)
        if (!skin.at(plan.chart(corner)))
          throw InputError(l.file, 0, "its plan leaves the skin; expected a place with more skin around it");
  if (with_plan || !svg.empty()) foretell(skin, plan, l.title, svg);
}

void check_repro(const Repro& r) {
  std::printf("repro       a refused cut of scene \"%s\" (hash %s), written by %s\n", r.scene.c_str(),
              hex(r.scene_hash).c_str(), r.program.c_str());
  std::printf("state       %zu commands before it, cells of %g mm, seed %llu, topology %s\n", r.commands.size(),
              r.cell_mm, static_cast<unsigned long long>(r.seed), hex(r.topology_hash).c_str());
  std::printf("refused     %s\n", to_json_line(r.refused).c_str());
  std::printf("reason      %s\n", r.reason.c_str());
}

int check_recording(const std::string& file, bool with_plan, int workers) {
  const Recording rec = read_recording(file);
  int64_t stylus = 0, stations = 0, controls = 0, raw_bytes = 0, first = 0, last = 0;
  for (const Sample& s : rec.samples) {
    const int64_t t = std::visit([](const auto& x) { return x.t_ns; }, s);
    if (&s == &rec.samples.front()) first = t;
    last = std::max(last, t);
    stylus += std::holds_alternative<StylusSample>(s);
    stations += std::holds_alternative<TrackerSample>(s);
    controls += std::holds_alternative<ControlSample>(s) || std::holds_alternative<CommandSample>(s);
    if (const auto* r = std::get_if<RawSample>(&s)) raw_bytes += r->n;
  }
  std::printf("recording   %lld events\n", static_cast<long long>(rec.events));
  if (rec.session)
    std::printf("session     scene %s (hash %s), by %s\n", rec.session->scene_name.c_str(),
                hex(rec.session->scene_hash).c_str(), rec.session->program.c_str());
  else
    std::printf("session     none: a plain stream, not a recording that replays by itself\n");
  const double seconds = double(last - first) * 1e-9;
  std::printf("samples     %lld stylus, %lld controls, %.2f s%s\n", static_cast<long long>(stylus),
              static_cast<long long>(controls), seconds,
              seconds > 0 ? (", " + std::to_string(int(double(stylus) / seconds + 0.5)) + " Hz").c_str() : "");
  if (stations > 0 || raw_bytes > 0)
    std::printf("tracker     %lld readings of stations, %lld bytes as they came\n", static_cast<long long>(stations),
                static_cast<long long>(raw_bytes));
  for (const Blob& b : rec.blobs) std::printf("holds       %s, %zu bytes\n", b.name.c_str(), b.data.size());
  std::printf("checkpoints %zu\n", rec.checkpoints.size());
  if (rec.schedule.broken)
    std::printf("schedule    not whole: replays, but not exactly as it was\n");
  else if (rec.schedule.usable())
    std::printf("schedule    %zu solver steps of a live session: replays exactly as it was\n",
                rec.schedule.solver.size());
  if (rec.session || rec.end) std::printf("end         %s\n", rec.end ? "whole" : "missing: the session was cut short");
  if (rec.session && rec.blob(BlobKind::scene)) {
    const Unbundled u = unbundle_scene(rec, file);
    if (u.scene.hash != rec.session->scene_hash)
      throw InputError(file, 0, "its scene is not the one that it was recorded with");
    check_scene(u.scene);
    if (with_plan) plan(u.scene, workers);
  }
  if (rec.damage.total() == 0) return kDone;
  const LogDamage& d = rec.damage;
  std::printf(
      "damage      %lld events lost: truncated %lld, bad sync %lld, bad length %lld, bad payload %lld, out of order "
      "%lld, missing %lld; %lld bytes skipped\n",
      static_cast<long long>(d.total()), static_cast<long long>(d.truncated), static_cast<long long>(d.bad_sync),
      static_cast<long long>(d.bad_length), static_cast<long long>(d.bad_payload),
      static_cast<long long>(d.out_of_order), static_cast<long long>(d.missing),
      static_cast<long long>(d.skipped_bytes));
  say(file + ": damaged: " + d.first_message);
  return kGoalMissed;
}

/// A surface that is smaller or larger than these was likely written in other units.
void note_size(double longest_mm, const std::string& unit) {
  constexpr double kSmall_mm = 10, kLarge_mm = 600;
  if (longest_mm >= kSmall_mm && longest_mm <= kLarge_mm) return;
  if (const std::string as = likely_units(longest_mm / mm_of(unit), kSmall_mm, kLarge_mm); !as.empty())
    std::printf("note        it is %.3g mm long: if its numbers are not mm, try %s\n", longest_mm, as.c_str());
}

/// A surface of one's own: whether it can be the body of a scene; and such a scene, if one is asked for.
void check_surface(const std::string& file, const std::string& text, const std::string& scene_file,
                   const std::string& unit, bool may_be_open) {
  ObjSpec spec;
  spec.path = file, spec.scale_to_mm = mm_of(unit);
  spec.layers.resize(1);
  SurfaceReport report;
  Body body;
  try {
    body = parse_obj(text, spec, &report);
  } catch (const InputError& e) {
    if (!may_be_open || !scene_file.empty()) throw;
    std::printf("body        none: %s\n", e.what());
    return;
  }
  print_surface(report);
  if (report.turned) std::printf("note        its triangles ran clockwise seen from outside: turned\n");
  if (!may_be_open) note_size((body.box_max_mm - body.box_min_mm).maxCoeff(), unit);
  if (scene_file.empty()) return;
  namespace fs = std::filesystem;
  std::error_code ec;
  if (fs::exists(scene_file, ec)) throw InputError(scene_file, 0, "exists already; expected the name of a new file");
  const fs::path beside = fs::absolute(scene_file).parent_path();
  write_whole_file(scene_file, first_scene(body, fs::absolute(file).lexically_relative(beside).string(), mm_of(unit)));
  std::printf("scene       %s; limberg run %s operates on it\n", scene_file.c_str(), scene_file.c_str());
}

void refuse_scene_of(const std::string& file, const std::string& scene_file) {
  if (!scene_file.empty())
    throw InputError(file, 0, "is no surface; --scene writes a scene for an OBJ, PLY or STL file");
}

/// A volume (or a folder of DICOM slices) or a scan; false: something else.
bool check_image(const std::string& file, const std::string& series, const std::string& scene_file,
                 const std::string& unit) {
  std::error_code ec;
  const bool folder = std::filesystem::is_directory(file, ec);
  const auto ends = [&](std::initializer_list<const char*> list) {
    return std::any_of(list.begin(), list.end(), [&](const char* e) { return std::string_view(file).ends_with(e); });
  };
  if (ends({".ply", ".stl", ".xyz"}) && !folder) {
    const std::string bytes = read_whole_file(file, SurfaceFileLimits::file_bytes, "a surface or a scan");
    const Surface s = parse_surface(bytes, file);
    if (s.tri.empty()) refuse_scene_of(file, scene_file);
    Vec3 low = s.x_mm.front(), high = low;
    for (const Vec3& x : s.x_mm) low = low.cwiseMin(x), high = high.cwiseMax(x);
    low *= mm_of(unit), high *= mm_of(unit);
    std::printf("%s %zu points, %zu triangles\nsize        %.1f x %.1f x %.1f mm\n",
                s.tri.empty() ? "scan       " : "surface    ", s.x_mm.size(), s.tri.size(), high.x() - low.x(),
                high.y() - low.y(), high.z() - low.z());
    note_size((high - low).maxCoeff(), unit);
    if (!s.tri.empty()) check_surface(file, bytes, scene_file, unit, true);
    return true;
  }
  // (The slices of a disc have names of any kind.)
  const auto dicom = [&] {
    return std::filesystem::is_regular_file(file, ec) && imaging::looks_like_dicom(read_beginning(file, 132));
  };
  if (!folder && !ends({".nrrd", ".nhdr", ".mha", ".mhd", ".nii", ".nii.gz", ".hdr", ".dcm", ".DCM", ".IMA"}) &&
      !dicom())
    return false;
  refuse_scene_of(file, scene_file);
  const LoadedVolume loaded = load_volume(file, LoadSettings{series, false});
  const Volume& v = loaded.volume;
  const auto [low, high] = std::minmax_element(v.value.begin(), v.value.end());
  std::printf(
      "volume      %d x %d x %d voxels of %.4g x %.4g x %.4g mm\nvalues      %g to %g\norigin      (%.2f, %.2f, %.2f) "
      "mm, left, posterior, superior\n",
      v.size[0], v.size[1], v.size[2], v.step_mm.col(0).norm(), v.step_mm.col(1).norm(), v.step_mm.col(2).norm(),
      double(*low), double(*high), v.origin_mm.x(), v.origin_mm.y(), v.origin_mm.z());
  for (const std::string& n : loaded.notes) std::printf("note        %s\n", n.c_str());
  return true;
}

/// The file as given, or a shipped one: by its path, or a scene by its name.
std::string meant(const std::string& given) {
  std::error_code ec;
  const std::string file = given_or_shipped(given);
  if (std::filesystem::exists(file, ec) || given.empty()) return file;
  const std::string scene = shipped_file("app/scenes/" + given + ".toml");
  return scene.empty() ? file : scene;
}

struct CheckOptions {
  std::string file, draw, series, scene, unit = "mm";
  bool plan = false;
  CommonOptions common;
};

int check(const CheckOptions& o) {
  const int workers = o.common.worker_count();
  const std::string file = meant(o.file);
  if (check_image(file, o.series, o.scene, o.unit)) return kDone;
  if (begins_recording(read_beginning(file, kBeginning))) {
    refuse_scene_of(file, o.scene);
    return check_recording(file, o.plan, workers);
  }
  const std::string text = read_whole_file(file, size_t(1) << 30);
  const Kind kind = recognise(file, text);
  if (kind != Kind::surface) refuse_scene_of(file, o.scene);
  switch (kind) {
    case Kind::recording:
      return check_recording(file, o.plan, workers);
    case Kind::repro:
      check_repro(parse_repro(text, file));
      break;
    case Kind::script:
      check_script(parse_script(text, file), file, o.plan, o.draw);
      break;
    case Kind::lesson:
      check_lesson(parse_lesson(text, file), o.plan, o.draw);
      break;
    case Kind::calibration: {
      const Calibration c = parse_calibration(text, file);
      std::printf("calibration %s, hash %s\n", c.name.c_str(), hex(calibration_hash(c)).c_str());
      if (!c.device.empty() || !c.date.empty())
        std::printf("device      %s, %s\n", c.device.empty() ? "not named" : c.device.c_str(),
                    c.date.empty() ? "no date" : c.date.c_str());
      std::printf(
          "stylus      tip (%.3f, %.3f, %.3f) mm\nworld       tracker at (%.2f, %.2f, %.2f) mm\nglove       closed "
          "%.1f mm, open %.1f mm\n",
          c.tip_offset_mm.x(), c.tip_offset_mm.y(), c.tip_offset_mm.z(), c.world_from_tracker_mm.x(),
          c.world_from_tracker_mm.y(), c.world_from_tracker_mm.z(), c.glove.closed_mm, c.glove.open_mm);
      if (!c.distortion.empty())
        std::printf("distortion  corrected on %d x %d x %d nodes\n", c.distortion.nodes[0], c.distortion.nodes[1],
                    c.distortion.nodes[2]);
      break;
    }
    case Kind::surface:
      check_surface(file, text, o.scene, o.unit, false);
      break;
    case Kind::simplex_mesh: {
      const simplex::Census c = simplex::census(simplex::parse_mesh(text, file));
      std::printf("simplex     %lld vertices, %lld faces, %lld parts, genus %lld, %lld end contours\n",
                  static_cast<long long>(c.vertices), static_cast<long long>(c.faces - c.end_contours),
                  static_cast<long long>(c.components), static_cast<long long>(c.genus),
                  static_cast<long long>(c.end_contours));
      break;
    }
    case Kind::tissues:
      check_tissues(parse_tissues(text, file, *shipped_laws()));
      break;
    case Kind::scene: {
      const Scene scene = load_scene(file);
      check_scene(scene);
      if (o.plan) plan(scene, workers);
      break;
    }
  }
  return kDone;
}

}  // namespace

void add_check(CLI::App& app, Chosen& chosen) {
  auto o = std::make_shared<CheckOptions>();
  CLI::App* c = app.add_subcommand("check", "Say what a file holds and whether it is sound");
  c->add_option("FILE", o->file,
                "Scene, lesson, library of tissues, script, repro, recording, calibration, OBJ surface or simplex "
                "mesh, known by its content; a volume, a folder of DICOM slices, a PLY, STL or xyz scan")
      ->required();
  c->add_option("--series", o->series, "Of a DICOM folder with several: number, UID or part of its description")
      ->type_name("NAME");
  c->add_flag("--plan", o->plan,
              "Of a scene: build it and say parts, nodes, memory, time of a step. Of a script or lesson: where its "
              "angles do not add up, so that the skin will stand up or be drawn tight");
  c->add_option("--draw", o->draw, "Draw the plan of a script or lesson, with what it foretells")->type_name("SVG");
  c->add_option("--scene", o->scene,
                "Of a closed surface (OBJ, PLY, STL): also write a scene to begin with, that has it as its body")
      ->type_name("TOML");
  add_unit(*c, o->unit, "Of the numbers in a surface or a scan");
  o->common.add_workers(*c);
  c->footer(
      "Exit status 3: a recording is damaged, but what is whole can be replayed.\n"
      "Example: limberg check app/scenes/rhomboid.toml --plan");
  c->callback([o, &chosen] { chosen = [o] { return check(*o); }; });
}

}  // namespace limberg
