// The skin block by an independent program: CalculiX (ccx),
// quadratic hexahedra, the same energy and the same dead load.
//
// Block 24 x 24 x 8 mm, held below; 2 mm of skin (60 kPa) on 6 mm of fat (15 kPa),
// nu 0.45; a patch of 8 x 8 mm in the middle of the skin carries 4 kPa along x and 5
// kPa upwards, fixed in direction and size. Energy of both: mu/2 (I1 J^-2/3 - 3) +
// K/2 (J - 1)^2, which CalculiX calls *HYPERELASTIC, NEO HOOKE with C10 = mu/2 and
// D1 = 2/K. At a hundredth of the load the scenes' own energy must agree too: all of
// these are the same to first order (lambda = lambda_Lame + mu, fem_model.h).
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "app/operating_point/cpu_clock.h"
#include "sim/fem/elements/material_points.h"
#include "sim/fem/materials/isotropic.h"
#include "sim/fem/model/box_model.h"
#include "tests/bench/verification_parts.h"

namespace limberg::bench {
namespace {

namespace fs = std::filesystem;

constexpr double side = 24, height = 8, skin = 2, patch = 8, poisson = 0.45, skin_kPa = 60, fat_kPa = 15;
const Vec3 traction_kPa(4, 0, 5);

struct Constants {
  double mu, bulk;
};
Constants constants(double young) {
  const double mu = young / (2 * (1 + poisson));
  return {mu, 2 * mu * poisson / (1 - 2 * poisson) + 2 * mu / 3};
}

/// Places that both are asked for: under the load, at its rim, beside it, below it.
const Vec3 probes[] = {{12, 12, 8}, {16, 12, 8}, {20, 12, 8}, {12, 16, 8}, {12, 12, 4}};

std::string deck(double load, std::map<int, size_t>& probe_of) {
  const int n = 12, layers = 4;  // elements of 2 mm
  std::ostringstream o;
  std::map<std::array<int, 3>, int> number;  // on the grid of half elements, at most one odd coordinate
  o << "*NODE, NSET=ALL\n";
  for (int k = 0; k <= 2 * layers; ++k)
    for (int j = 0; j <= 2 * n; ++j)
      for (int i = 0; i <= 2 * n; ++i) {
        if (i % 2 + j % 2 + k % 2 > 1) continue;
        const int id = int(number.size()) + 1;
        number[{i, j, k}] = id;
        o << id << ", " << i << ", " << j << ", " << k << "\n";  // half elements are 1 mm
      }
  static const int corner[20][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                                    {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
                                    {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};
  int element = 0;
  for (const bool top : {false, true}) {
    o << "*ELEMENT, TYPE=C3D20R, ELSET=" << (top ? "SKIN" : "FAT") << "\n";
    for (int k = top ? layers - 1 : 0; k < (top ? layers : layers - 1); ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          o << ++element;
          for (int a = 0; a < 20; ++a)
            o << (a == 10 ? ",\n" : ", ") << number[{2 * i + corner[a][0], 2 * j + corner[a][1], 2 * k + corner[a][2]}];
          o << "\n";
        }
  }
  for (const bool top : {false, true}) {
    const Constants c = constants(top ? skin_kPa : fat_kPa);
    const std::string line = fmt::format("{:.12g}, {:.12g}", c.mu / 2, 2 / c.bulk);
    o << "*MATERIAL, NAME=" << (top ? "MSKIN" : "MFAT") << "\n*HYPERELASTIC, NEO HOOKE\n"
      << line << "\n*SOLID SECTION, ELSET=" << (top ? "SKIN" : "FAT") << ", MATERIAL=" << (top ? "MSKIN" : "MFAT")
      << "\n";
  }
  o << "*NSET, NSET=HELD\n";
  for (const auto& [at, id] : number)
    if (at[2] == 0) o << id << ",\n";
  o << "*NSET, NSET=PROBE\n";
  for (size_t k = 0; k < std::size(probes); ++k) {
    const int id = number[{int(probes[k][0]), int(probes[k][1]), int(probes[k][2])}];
    probe_of[id] = k;
    o << id << ",\n";
  }
  o << "*BOUNDARY\nHELD, 1, 3, 0.\n*STEP, NLGEOM, INC=200\n*STATIC\n0.25, 1.\n*CLOAD\n";
  // Consistent with the eight nodes of a square: a third of its
  // load on each side's middle, less a twelfth on each corner.
  std::map<int, double> share;
  const int first = int((side - patch) / 4), last = int((side + patch) / 4);
  for (int j = first; j < last; ++j)
    for (int i = first; i < last; ++i)
      for (int b = 0; b <= 2; ++b)
        for (int a = 0; a <= 2; ++a)
          if (a != 1 || b != 1)
            share[number[{2 * i + a, 2 * j + b, 2 * layers}]] += 4.0 * (a == 1 || b == 1 ? 1.0 / 3 : -1.0 / 12);
  for (const auto& [id, area] : share)
    for (int d = 0; d < 3; ++d)
      if (traction_kPa[d] != 0) o << id << ", " << d + 1 << ", " << load * area * traction_kPa[d] << "\n";
  o << "*NODE PRINT, NSET=PROBE\nU\n*END STEP\n";
  return o.str();
}

/// Displacements at the probes; empty when ccx is not there or failed (`why` says which).
std::vector<Vec3> calculix(double load, std::string& why) {
  std::string folder = (fs::temp_directory_path() / "limberg-ccx-XXXXXX").string();
  if (!mkdtemp(folder.data())) return why = "no temporary folder", std::vector<Vec3>();
  std::map<int, size_t> probe_of;
  std::ofstream(folder + "/block.inp") << deck(load, probe_of);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  for (int fd : {1, 2}) posix_spawn_file_actions_addopen(&actions, fd, "/dev/null", O_WRONLY, 0);
  char program[] = "ccx", option[] = "-i", job[] = "block", threads[] = "OMP_NUM_THREADS=1";
  char* const argv[] = {program, option, job, nullptr};
  std::string path = std::string("PATH=") + (std::getenv("PATH") ? std::getenv("PATH") : "/usr/bin");
  char* const environment[] = {threads, path.data(), nullptr};
  pid_t child = 0;
  int status = 0;
  const int failed = posix_spawnp(&child, program, &actions, nullptr, argv, environment);
  posix_spawn_file_actions_destroy(&actions);
  std::vector<Vec3> u;
  if (failed) {
    why = "ccx is not installed (Debian: calculix-ccx)";
  } else {
    waitpid(child, &status, 0);
    std::ifstream in(folder + "/block.dat");
    std::vector<Vec3> rows(std::size(probes), Vec3::Zero());  // of the last increment
    size_t read = 0;
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      int id;
      Vec3 v;
      if (words >> id >> v[0] >> v[1] >> v[2] && probe_of.count(id)) rows[probe_of[id]] = v, ++read;
    }
    if (!WIFEXITED(status) || read < rows.size())
      why = "ccx found no solution";
    else
      u = rows;
  }
  std::error_code none;
  fs::remove_all(folder, none);
  return u;
}

/// Ours at cells of h; `own`: the scenes' energy instead of the common one.
std::vector<Vec3> ours(double h, double load, bool own, size_t& nodes, bool& converged) {
  BoxSpec b;
  b.cells = {int(std::lround(side / h)), int(std::lround(side / h)), int(std::lround(height / h))},
  b.size_mm = {side, side, height};
  b.poisson = poisson, b.fix_bottom = true;
  FemModel m = box_model(b);
  for (Vec3& X : m.X_mm) X += Vec3(side / 2, side / 2, 0);
  m.stencils.clear();
  for (const double young : {fat_kPa, skin_kPa}) {
    const Constants c = constants(young);
    if (own) {
      m.stencils.push_back(box_stencil(m.cell_mm, elastic_from_young(young, poisson)));
      continue;
    }
    // Shape at the Gauss points, volume once: the scenes' integration
    // rule. The law is complete; its own volume part is made negligible.
    m.laws.push_back(neo_hookean_isochoric_full(c.mu, 1e-9 * c.mu));
    Stencil law = fem::law_stencil(m.cell_mm, int32_t(m.laws.size()) - 1, *m.laws.back(), c.bulk);
    law.p0_kPa = 0;
    m.stencils.push_back(law);
  }
  for (HexCell& c : m.cells) c.stencil = m.X_mm[size_t(c.node[0])][2] > height - skin - 1e-9;
  std::vector<double> area(m.X_mm.size(), 0);
  const double low = (side - patch) / 2 - 1e-9, high = (side + patch) / 2 + 1e-9;
  for (const HexCell& c : m.cells) {
    const Vec3 a = m.X_mm[size_t(c.node[4])], z = m.X_mm[size_t(c.node[7])];
    if (a[2] < height - 1e-9 || a[0] < low || a[1] < low || z[0] > high || z[1] > high) continue;
    for (size_t k = 4; k < 8; ++k) area[size_t(c.node[k])] += h * h / 4;
  }
  std::vector<Spring> springs;
  for (size_t i = 0; i < area.size(); ++i)
    if (area[i] > 0)
      springs.push_back(dead_load(m, int32_t(i), int32_t(i), load * area[i] * traction_kPa, 1e-5 * load, Vec3::Zero()));
  const ReferenceElasticity energy(m, springs);
  ReferenceElasticity::Settings s;
  s.max_iterations = 60, s.tolerance = 1e-8;
  const auto r = energy.solve(std::vector<Vec3>(m.X_mm.size(), Vec3::Zero()), s);
  nodes = m.X_mm.size(), converged = r.residual < 1e-6;
  std::vector<Vec3> u;
  for (const Vec3& p : probes)
    for (size_t i = 0; i < m.X_mm.size(); ++i)
      if ((m.X_mm[i] - p).norm() < 1e-6) {
        u.push_back(r.u[i]);
        break;
      }
  return u;
}

}  // namespace

void calculix_block(Result& out, const VerificationSettings& set) {
  if (set.quick) return;
  struct Case {
    const char* name;
    double load;
    bool own;
  };
  for (const Case& c : {Case{"skin block, full load, common energy", 1, false},
                        Case{"skin block, 1/100 of the load, scenes' energy", 0.01, true}}) {
    std::string why;
    const std::vector<Vec3> found = calculix(c.load, why);
    if (found.empty()) {
      out.notes.push_back(std::string("CalculiX: ") + why + "; the comparison was skipped");
      return;
    }
    double size = 0;
    for (const Vec3& u : found) size = std::max(size, u.norm());
    for (double h : {2.0, 1.0, 2.0 / 3}) {
      const double before = cpu_ms();
      size_t nodes = 0;
      bool converged = false;
      const std::vector<Vec3> u = ours(h, c.load, c.own, nodes, converged);
      double error = 0;
      for (size_t k = 0; k < found.size(); ++k) error = std::max(error, 100 * (u[k] - found[k]).norm() / size);
      const std::string how =
          fmt::format("cells of {:.3g} mm, {} nodes, largest displacement {:.4f} mm", h, nodes, size);
      out.rows.push_back({c.name, "hexahedra, selective reduced", how, cpu_ms() - before, false, error, "%",
                          "CalculiX, C3D20R of 2 mm, five places", converged});
      if (h < 1)
        at_most(out, std::string("CalculiX, ") + c.name + ": displacement at the finest mesh (%)", error, 1,
                "issue 4: within 1 %");
    }
  }
}

}  // namespace limberg::bench
