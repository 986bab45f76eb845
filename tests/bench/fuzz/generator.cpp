#include "tests/bench/fuzz/generator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace limberg::fuzz {
namespace {

/// Triangles of a sheet whose vertices are a grid of n x m squares, row by row; all of it drawn inside the body.
void sew_grid(Op& op, int n, int m) {
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int32_t a = j * (n + 1) + i, b = a + 1, d = a + n + 1, e = d + 1;
      op.tri.push_back({a, b, e});
      op.tri.push_back({a, e, d});
    }
  op.seed_of_tri.assign(op.tri.size(), 2);
}

}  // namespace

Case Generator::start(int front_levels) {
  Case c;
  c.front_levels = front_levels;
  c.body.size_mm = 24;
  c.body.columns = random_.one_in(3) ? 4 : 6;
  c.body.thickness_mm = random_.one_in(4) ? random_.real(0.6, 3) : random_.real(5, 10);
  c.body.wave_mm = adversarial_ ? 0 : random_.real(0, std::min(0.8, 0.4 * c.body.thickness_mm));
  c.body.loose = random_.one_in(4);
  c.cell_mm = random_.real(4, 9);
  c.lattice_shift = random_.real(0.05, 0.9);
  if (adversarial_) {
    c.body.thickness_mm = std::max(1.0, std::round(c.body.thickness_mm));
    c.cell_mm = std::round(c.cell_mm);
    c.lattice_shift = random_.below(2) * 0.5;
  }
  case_ = c;
  return c;
}

void Generator::begin_blade(const Runner& runner) {
  step_ = random_.real(3, 9);
  for (Snap& s : snap_) s = adversarial_ && !random_.one_in(5) ? Snap(1 + random_.below(5)) : none;
  past_.clear();
  for (const Made& m : runner.made()) past_.insert(past_.end(), m.op.vertex.begin(), m.op.vertex.end());
}

Int3 Generator::place(const Vec3& mm) {
  const RestGrid g;
  Int3 p = g.to_grid(mm);
  const LatticeGrid lattice = make_lattice(case_, case_.cell_mm);
  for (int a = 0; a < 3; ++a) {
    const auto to = [&](double spacing, double offset) {
      return 2 * int32_t(std::lround((std::round((p[a] - offset) / spacing) * spacing + offset) / 2));
    };
    int32_t q = p[a];
    switch (snap_[a]) {
      case none:
        break;
      case units16:
        q = to(32 * 64, 0);  // 16 units are two micrometres; 64 times that, so that much coincides
        break;
      case whole_mm:
        q = to(16384, 0);
        break;
      case body_columns: {
        const double spacing = (a < 2 ? case_.body.size_mm / case_.body.columns : case_.body.thickness_mm) * 16384;
        q = to(spacing, a < 2 ? -case_.body.size_mm / 2 * 16384 : 0);
        break;
      }
      case planes:
        q = to(lattice.pitch[a], lattice.origin[a]) + (random_.one_in(2) ? 0 : 2);
        q = q / 2 * 2;
        break;
      case past: {
        int32_t best = q;
        for (const Int3& v : past_)
          if (best == q || std::abs(v[a] - p[a]) < std::abs(best - p[a])) best = v[a];
        if (std::abs(best - p[a]) < 16384 * 4) q = best;
        break;
      }
    }
    if (a == 0) p.x = q;
    if (a == 1) p.y = q;
    if (a == 2) p.z = q;
  }
  return p;
}

Vec2 Generator::around(double share) {
  const double h = share * case_.body.size_mm / 2;
  return {random_.real(-h, h), random_.real(-h, h)};
}

void Generator::finish_strip(Op& op, const std::vector<Vec2>& path, double top, double bottom, bool closed,
                             const Vec2& lean) {
  std::vector<Vec2> p;
  const size_t segments = closed ? path.size() : path.size() - 1;
  for (size_t i = 0; i < segments; ++i) {
    const Vec2 a = path[i], b = path[(i + 1) % path.size()];
    const int n = std::max(1, int(std::ceil((b - a).norm() / step_)));
    for (int k = 0; k < n; ++k) p.push_back(a + (b - a) * (double(k) / n));
  }
  if (!closed) p.push_back(path.back());
  for (const Vec2& q : p) {
    op.vertex.push_back(place({q.x(), q.y(), top}));
    const Vec2 foot = q + lean;
    op.vertex.push_back(place({foot.x(), foot.y(), bottom}));
  }
  const int32_t n = int32_t(p.size());
  for (int32_t i = 0; i < (closed ? n : n - 1); ++i) {
    const int32_t j = (i + 1) % n;
    op.tri.push_back({2 * i, 2 * i + 1, 2 * j + 1});
    op.tri.push_back({2 * i, 2 * j + 1, 2 * j});
  }
  op.seed_of_tri.assign(op.tri.size(), 1);
}

Op Generator::incise(int bends) {
  Op op;
  op.name = bends == 0 ? "incise" : "incise, bent";
  std::vector<Vec2> path{around(0.9)};
  double heading = random_.real(0, 2 * std::numbers::pi);
  for (int i = 0; i <= bends; ++i) {
    const double length = random_.real(2, bends ? 9 : 20);
    path.push_back(path.back() + length * Vec2(std::cos(heading), std::sin(heading)));
    heading += random_.real(-1.6, 1.6);
  }
  const double depth = random_.real(0.5, 1.2 * case_.body.thickness_mm);
  const Vec2 lean = random_.one_in(3) ? Vec2{random_.real(-2, 2), random_.real(-2, 2)} : Vec2(0, 0);
  finish_strip(op, path, case_.body.wave_mm + random_.real(0.5, 2), -depth, false, lean);
  if (random_.one_in(6)) op.seed_of_tri[0] = op.seed_of_tri[1] = 0;
  return op;
}

Op Generator::loop(bool through) {
  Op op;
  op.name = through ? "loop, through" : "loop";
  const Vec2 c = around(0.6);
  const double r = random_.real(1.5, 6);
  const int n = 3 + random_.below(4);
  const double turn = random_.real(0, 6.28);
  std::vector<Vec2> path;
  for (int i = 0; i < n; ++i) {
    const double t = turn + 2 * std::numbers::pi * i / n;
    path.push_back(c + r * Vec2(std::cos(t), std::sin(t)));
  }
  finish_strip(op, path, case_.body.wave_mm + 1,
               through ? -case_.body.thickness_mm - 1 : -random_.real(1, case_.body.thickness_mm), true, {0, 0});
  return op;
}

Op Generator::cross(const Runner& runner) {
  const Made& m = runner.made()[size_t(random_.below(int(runner.made().size())))];
  if (m.op.vertex.empty()) return incise(0);
  const Int3 v = m.op.vertex[size_t(random_.below(int(m.op.vertex.size())))];
  const double u = RestGrid{}.half_unit_mm();
  const Vec2 c(v.x * u, v.y * u);
  Op op;
  op.name = "cross";
  const double t = random_.real(0, 2 * std::numbers::pi), l = random_.one_in(3) ? 40 : random_.real(2, 12);
  const Vec2 d(std::cos(t), std::sin(t));
  // Across, or ending on it (T) by a little or exactly.
  const double beyond = random_.one_in(2) ? l : random_.below(3) * 0.05;
  finish_strip(op, {c - l * d, c + beyond * d}, case_.body.wave_mm + 1,
               l > 20 ? -case_.body.thickness_mm - 1 : -random_.real(0.5, case_.body.thickness_mm), false, {0, 0});
  if (beyond == 0 && op.vertex.size() > 2) {  // a degenerate end was made longer than nothing by rounding, or is
    op.name = "T";
  }
  return op;
}

Op Generator::deepen(const Runner& runner, int32_t) {
  // The lower edge of an earlier strip, by its own vertices.
  const Made& m = runner.made()[size_t(random_.below(int(runner.made().size())))];
  const size_t length = m.op.vertex.size() / 2;
  if (m.op.kind != Op::cut || m.op.tri.size() + 2 < 2 * length || length < 2 || m.blade_point.empty() ||
      m.op.seed_of_tri.empty() || m.op.seed_of_tri.back() != 1)
    return incise(1);
  Op op;
  op.name = "deepen";
  const double drop = random_.real(0.3, 4);
  const size_t from = size_t(random_.below(int(length - 1)));
  const size_t to = from + 1 + size_t(random_.below(int(length - 1 - from)));
  for (size_t i = from; i <= to; ++i) {
    const int32_t id = int32_t(2 * i + 1);
    const Int3 p = runner.arrangement().explicit_point(m.blade_point[size_t(id)]);
    const double u = RestGrid{}.half_unit_mm();
    op.vertex.push_back(p);
    op.shared.push_back({m.number, id});
    op.vertex.push_back(place({p.x * u + random_.real(-0.3, 0.3), p.y * u + random_.real(-0.3, 0.3), p.z * u - drop}));
    op.shared.push_back({-1, -1});
  }
  const int32_t n = int32_t(op.vertex.size() / 2);
  for (int32_t i = 0; i + 1 < n; ++i) {
    op.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    op.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  op.seed_of_tri.assign(op.tri.size(), 2);
  return op;
}

Op Generator::prolong(const Runner& runner, int32_t) {
  const Made& m = runner.made()[size_t(random_.below(int(runner.made().size())))];
  const size_t n = m.op.vertex.size();
  if (m.op.kind != Op::cut || n < 4 || n % 2 || m.blade_point.empty() || m.op.seed_of_tri.back() != 1) return incise(2);
  Op op;
  op.name = "prolong";
  const double u = RestGrid{}.half_unit_mm();
  Vec3 end[2], before[2];
  for (size_t k = 0; k < 2; ++k) {
    const Int3 p = runner.arrangement().explicit_point(m.blade_point[n - 2 + k]),
               q = runner.arrangement().explicit_point(m.blade_point[n - 4 + k]);
    end[k] = u * Vec3(p.x, p.y, p.z);
    before[k] = u * Vec3(q.x, q.y, q.z);
    op.vertex.push_back(p);
    op.shared.push_back({m.number, int32_t(n - 2 + k)});
  }
  const double turn = random_.real(-0.9, 0.9);
  Vec3 d = end[0] - before[0];
  d = Vec3(std::cos(turn) * d.x() - std::sin(turn) * d.y(), std::sin(turn) * d.x() + std::cos(turn) * d.y(), 0);
  const int more = 1 + random_.below(2);
  for (int i = 1; i <= more; ++i)
    for (size_t k = 0; k < 2; ++k) {
      op.vertex.push_back(place(end[k] + double(i) * d));
      op.shared.push_back({-1, -1});
    }
  for (int32_t i = 0; i < more; ++i) {
    op.tri.push_back({2 * i, 2 * i + 1, 2 * i + 3});
    op.tri.push_back({2 * i, 2 * i + 3, 2 * i + 2});
  }
  op.seed_of_tri.assign(op.tri.size(), 1);
  return op;
}

Op Generator::sheet() {
  Op op;
  op.name = "sheet";
  const Vec2 c = around(0.8);
  const double t = random_.real(0, 6.28), z = -random_.real(0.2, case_.body.thickness_mm);
  // Braces: the draws come in this order with every compiler.
  const Vec3 u{random_.real(4, 18) * std::cos(t), random_.real(4, 18) * std::sin(t),
               random_.one_in(2) ? 0 : random_.real(-2, 2)};
  const Vec3 v{-random_.real(4, 18) * std::sin(t), random_.real(4, 18) * std::cos(t),
               random_.one_in(2) ? 0 : random_.real(-2, 2)};
  const int n = 1 + random_.below(3), m = 1 + random_.below(3);
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i)
      op.vertex.push_back(place(Vec3(c.x(), c.y(), z) + u * (double(i) / n - 0.5) + v * (double(j) / m - 0.5)));
  sew_grid(op, n, m);
  return op;
}

Op Generator::undermine(const Runner& runner) {
  const Made& m = runner.made()[size_t(random_.below(int(runner.made().size())))];
  if (m.op.vertex.empty()) return sheet();
  const double u = RestGrid{}.half_unit_mm();
  Vec3 lo = u * Vec3(m.op.vertex[0].x, m.op.vertex[0].y, m.op.vertex[0].z), hi = lo;
  for (const Int3& p : m.op.vertex) {
    lo = lo.cwiseMin(u * Vec3(p.x, p.y, p.z));
    hi = hi.cwiseMax(u * Vec3(p.x, p.y, p.z));
  }
  // A level sheet that begins at, or a little beyond, the wall; above its lower edge, or exactly at it.
  Op op;
  op.name = "undermine";
  const double z = random_.one_in(3) ? lo.z() : std::min(-0.1, lo.z() + random_.real(0.05, 2));
  const double beyond = random_.below(3) * 0.1;
  const double w = random_.real(3, 12), side = random_.one_in(2) ? 1 : -1;
  const Vec2 a(lo.x() - beyond, lo.y()), b(hi.x() + beyond, hi.y());
  const Vec2 along = b - a, across = side * w * Vec2(-along.y(), along.x()).normalized();
  if (along.norm() < 0.5) return sheet();
  const Vec2 start = a - across.normalized() * beyond;
  const int n = 1 + random_.below(3), k = 1 + random_.below(2);
  for (int j = 0; j <= k; ++j)
    for (int i = 0; i <= n; ++i) {
      const Vec2 p = start + along * (double(i) / n) + across * (double(j) / k);
      op.vertex.push_back(place({p.x(), p.y(), z}));
    }
  sew_grid(op, n, k);
  return op;
}

Op Generator::plug() {
  Op op = loop(false);
  op.name = "plug";
  const int32_t rim = int32_t(op.vertex.size() / 2), centre = int32_t(op.vertex.size());
  double x = 0, y = 0, z = 0;
  for (int32_t i = 0; i < rim; ++i)
    x += op.vertex[size_t(2 * i + 1)].x, y += op.vertex[size_t(2 * i + 1)].y, z += op.vertex[size_t(2 * i + 1)].z;
  const double u = RestGrid{}.half_unit_mm() / rim;
  op.vertex.push_back(place({x * u, y * u, z * u}));
  for (int32_t i = 0; i < rim; ++i) op.tri.push_back({2 * i + 1, 2 * ((i + 1) % rim) + 1, centre});
  op.seed_of_tri.assign(op.tri.size(), 2);
  return op;
}

Op Generator::again(const Runner& runner) {
  const Made& m = runner.made()[size_t(random_.below(int(runner.made().size())))];
  if (m.op.vertex.empty()) return incise(0);
  Op op;
  op.name = "again";
  op.vertex = m.op.vertex;
  op.tri = m.op.tri;
  op.seed_of_tri = m.op.seed_of_tri;
  const int how = random_.below(5);
  const int32_t by = how == 0 ? 0 : how == 1 ? 2 : how == 2 ? 983 * 2 : 4096;  // 0, 0.12 um, 120 um, 250 um
  const int axis = how < 3 ? random_.below(3) : 2;
  for (Int3& v : op.vertex) (axis == 0 ? v.x : axis == 1 ? v.y : v.z) -= by;
  if (how == 4)
    for (size_t i = 1; i < op.vertex.size(); i += 2) op.vertex[i].z -= 8192;
  return op;
}

Op Generator::fold() {
  // A strip wound about an upright axis so tightly that it may run through itself, or nearly.
  Op op;
  op.name = "fold";
  const Vec2 c = around(0.7);
  std::vector<Vec2> path;
  const double r = random_.real(0.5, 4), pitch = random_.real(-0.15, 0.3);
  double turn = random_.real(0, 6.28);
  const int n = 4 + random_.below(8);
  for (int i = 0; i < n; ++i, turn += random_.real(0.5, 1.3))
    path.push_back(c + (r + pitch * i) * Vec2(std::cos(turn), std::sin(turn)));
  const Vec2 lean{random_.real(-1, 1), random_.real(-1, 1)};
  finish_strip(op, path, case_.body.wave_mm + 1, -random_.real(0.5, case_.body.thickness_mm), false, lean);
  return op;
}

Op Generator::fan() {
  // Triangles about one vertex in the material: a cone, or part of one.
  Op op;
  op.name = "fan";
  const Vec2 c = around(0.7);
  op.vertex.push_back(place({c.x(), c.y(), -random_.real(0.3, case_.body.thickness_mm + 1)}));
  const int n = 3 + random_.below(4);
  const double turn = random_.real(0, 6.28), r = random_.real(1, 7),
               full = random_.one_in(2) ? 6.2831853 : random_.real(1, 5);
  const bool closed = full > 6;
  for (int i = 0; i < (closed ? n : n + 1); ++i) {
    const double t = turn + full * i / n;
    op.vertex.push_back(
        place({c.x() + r * std::cos(t), c.y() + r * std::sin(t), case_.body.wave_mm + random_.real(0.2, 2)}));
  }
  for (int i = 0; i < n; ++i) op.tri.push_back({0, 1 + i, 1 + (closed ? (i + 1) % n : i + 1)});
  op.seed_of_tri.assign(op.tri.size(), uint8_t(1 + random_.below(2)));
  return op;
}

Op Generator::next(const Runner& runner, int32_t number) {
  begin_blade(runner);
  const bool some = !runner.made().empty();
  Op op;
  const int dice = random_.below(100);
  if (dice < 10) {
    op = incise(0);
  } else if (dice < 18) {
    op = incise(1 + random_.below(2));
  } else if (dice < 24) {
    op = loop(random_.one_in(3));
  } else if (dice < 36) {
    op = some ? cross(runner) : incise(0);
  } else if (dice < 42) {
    op = some ? deepen(runner, number) : incise(0);
  } else if (dice < 46) {
    op = some ? prolong(runner, number) : incise(1);
  } else if (dice < 56) {
    op = some ? undermine(runner) : sheet();
  } else if (dice < 61) {
    op = sheet();
  } else if (dice < 66) {
    op = plug();
  } else if (dice < 70) {
    op = some ? again(runner) : plug();
  } else if (dice < 72) {
    op = fold();
  } else if (dice < 75) {
    op = fan();
  } else if (dice < 81) {
    op.kind = Op::excise;
    op.which = random_.one_in(3) ? random_.below(1000) : 0;
    return op;
  } else if (dice < 90) {
    op.kind = Op::undo;
    return op;
  } else if (dice < 95) {
    op.kind = Op::redo;
    return op;
  } else if (dice < 96) {
    op.kind = Op::replay;
    op.cell_mm = random_.one_in(3) ? random_.real(3, 12) : case_.cell_mm / 2;
    return op;
  } else {
    op = random_.one_in(2) && some ? cross(runner) : some ? undermine(runner) : incise(1);
    op.kind = Op::fault;
    op.place = random_.real(0, 1);
    op.in_lattice = random_.one_in(4);
    op.thrown = random_.one_in(3);
    op.lasting = random_.one_in(2);
  }
  op.seed = random_.next();
  if (op.shared.empty()) op.shared.assign(op.vertex.size(), {-1, -1});
  if (op.kind == Op::cut && random_.one_in(5)) op.sweep_mm3 = 1;
  return op;
}

}  // namespace limberg::fuzz
